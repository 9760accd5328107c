#include <algorithm>
#include <cmath>

#include "livemvs/eval/color_ramp.h"
#include "livemvs/eval/render.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr Rgb kBackgroundTop = {240, 242, 245};
constexpr Rgb kBackgroundBottom = {206, 211, 218};

/// How the light falls: `ambient` everywhere, `diffuse` on what faces the lamp.
struct Lighting {
  float ambient, diffuse, edge_strength;
};

/// The lamp stands behind the viewer, up and to the left. Camera axes: x right, y down, z forward.
const Eigen::Vector3f kToLamp = Eigen::Vector3f(-0.4f, -0.65f, -1).normalized();

float Diffuse(Eigen::Vector3f normal) {
  if (normal.isZero()) return 0.8f;
  if (normal.z() > 0) normal = -normal;  // surfaces have two sides
  return std::max(normal.dot(kToLamp), 0.0f);
}

/// Share of light left at a pixel beside something nearer: eye-dome lighting (Boucheny, 2009), on
/// steps of depth measured in widths of the neighbourhood.
float EdgeShade(
    const FragmentImage& image, int x, int y, int reach, float px_size, float strength) {
  constexpr int kDirections[8][2] = {
      {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  constexpr float kSlopeAllowed = 1.2f, kMaxStep = 6;
  const float depth = image.At(x, y).depth;
  float sum = 0;
  for (const auto& d : kDirections) {
    const int nx = x + d[0] * reach, ny = y + d[1] * reach;
    if (nx < 0 || ny < 0 || nx >= image.width || ny >= image.height) continue;
    const float neighbor = image.At(nx, ny).depth;
    if (!(neighbor < depth)) continue;
    const float step = (depth - neighbor) / (px_size * depth * static_cast<float>(reach));
    sum += std::clamp(step - kSlopeAllowed, 0.0f, kMaxStep);
  }
  return std::exp(-strength * sum / 8);
}

}  // namespace

RgbImage ShadeFragments(const FragmentImage& image, int scale, double focal_px, bool true_color) {
  const Lighting light = true_color ? Lighting{0.62f, 0.42f, 0.22f} : Lighting{0.30f, 0.75f, 0.28f};
  RgbImage picture(image.width / scale, image.height / scale);
  const Eigen::Vector3f top = LinearFromSrgb(kBackgroundTop);
  const Eigen::Vector3f bottom = LinearFromSrgb(kBackgroundBottom);
  const float px_size = static_cast<float>(1 / focal_px);
  ParallelFor(static_cast<std::size_t>(picture.height()), [&](std::size_t index) {
    const int row = static_cast<int>(index);
    const float t = static_cast<float>(row) / static_cast<float>(std::max(picture.height() - 1, 1));
    const Eigen::Vector3f background = top + t * (bottom - top);
    for (int column = 0; column < picture.width(); ++column) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int y = row * scale; y < (row + 1) * scale; ++y) {
        for (int x = column * scale; x < (column + 1) * scale; ++x) {
          const Fragment& fragment = image.At(x, y);
          if (std::isinf(fragment.depth)) {
            sum += background;
            continue;
          }
          const float edges = EdgeShade(image, x, y, scale, px_size, light.edge_strength) *
                              EdgeShade(image, x, y, 3 * scale, px_size, light.edge_strength);
          sum +=
              fragment.color * (light.ambient + light.diffuse * Diffuse(fragment.normal)) * edges;
        }
      }
      picture(column, row) = SrgbFromLinear(sum / static_cast<float>(scale * scale));
    }
  });
  return picture;
}

}  // namespace livemvs
