#include "livemvs/pipeline/side_check.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "livemvs/core/texture.h"

namespace livemvs {
namespace {

// Variance that is texture, in those of the noise.
constexpr float kTexture = 8;

// Windows of less variance match nothing [grey levels²].
constexpr float kLeastVariance = 0.5F;

// Sums over some pixels of a patch and of a window.
struct Sums {
  float n = 0, p = 0, w = 0, pp = 0, pw = 0, ww = 0;

  void Add(float patch, float window) {
    ++n;
    p += patch;
    w += window;
    pp += patch * patch;
    pw += patch * window;
    ww += window * window;
  }
  void Add(const Sums& s) {
    n += s.n;
    p += s.p;
    w += s.w;
    pp += s.pp;
    pw += s.pw;
    ww += s.ww;
  }
};

// NCC over three neighbouring rows or columns; 1 where the patch has no texture there.
float NccOf(const Sums& first, const Sums& second, const Sums& third, float least_variance) {
  Sums s = first;
  s.Add(second);
  s.Add(third);
  const float patch_variance = s.pp / s.n - s.p * s.p / (s.n * s.n);
  if (!(patch_variance > least_variance)) return 1;
  const float window_variance = s.ww / s.n - s.w * s.w / (s.n * s.n);
  const float covariance = s.pw / s.n - s.p * s.w / (s.n * s.n);
  return covariance / std::sqrt(patch_variance * std::max(window_variance, kLeastVariance));
}

// Where a patch lies in a picture, at a level of its pyramid [px].
struct Grid {
  Eigen::Vector2d center;
  Eigen::Vector2d right, down;  // steps per pixel of the patch
};

// Nothing where a part of the patch is behind the camera or out of the lens model's range.
std::optional<Grid> GridOf(const ReferenceFrame& reference,
                           const Rigid3d& cam_from_world,
                           const Projector& projector,
                           double bx,
                           double by,
                           double z_depth) {
  const Camera& camera = reference.camera;
  const Eigen::Matrix2d bearing_per_pixel = BearingPerPixel(camera, bx, by);
  const Rigid3d cur_from_ref = cam_from_world * reference.cam_from_world.Inverse();
  const auto project = [&](const Eigen::Vector2d& step) {
    const Eigen::Vector2d bearing = Eigen::Vector2d(bx, by) + bearing_per_pixel * step;
    return projector.Project(
        cur_from_ref * Eigen::Vector3d(z_depth * bearing.x(), z_depth * bearing.y(), z_depth));
  };
  const auto center = project({0, 0}), right = project({1, 0}), below = project({0, 1});
  if (!center || !right || !below) return std::nullopt;
  const double scale = std::ldexp(1.0, -reference.level);  // see AtLevel()
  const Eigen::Vector2d half(0.5, 0.5);
  return Grid{
      scale * (*center + half) - half, scale * (*right - *center), scale * (*below - *center)};
}

// Nothing where a sample lies less than a pixel from the border, or outside.
std::optional<PatchValues> Sample(const ImageView<std::uint8_t>& image, const Grid& grid) {
  const Eigen::Array2d reach = kPatchRadius * (grid.right.array().abs() + grid.down.array().abs());
  const Eigen::Array2d center = grid.center.array();
  const Eigen::Array2d last(image.width - 2, image.height - 2);
  if (!((center - reach >= 1).all() && (center + reach <= last).all())) return std::nullopt;
  PatchValues values;
  for (int k = 0; k < kPatchPixels; ++k) {
    const Eigen::Vector2d at = grid.center + (k % kPatchSize - kPatchRadius) * grid.right +
                               (k / kPatchSize - kPatchRadius) * grid.down;
    const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
    const auto fx = static_cast<float>(at.x() - column), fy = static_cast<float>(at.y() - row);
    const std::uint8_t* upper = &image(column, row);
    const std::uint8_t* lower = upper + image.stride;
    const float above = upper[0] + fx * static_cast<float>(upper[1] - upper[0]);
    const float below = lower[0] + fx * static_cast<float>(lower[1] - lower[0]);
    values[k] = above + fy * (below - above);
  }
  return values;
}

}  // namespace

float LeastSideNcc(const PatchValues& patch, const PatchValues& window, float noise2) {
  // About the patches' middles: sums of squares of grey levels are large.
  constexpr int kMiddle = kPatchPixels / 2;
  std::array<Sums, kPatchSize> rows, columns;
  for (int k = 0; k < kPatchPixels; ++k) {
    const float p = patch[k] - patch[kMiddle], w = window[k] - window[kMiddle];
    rows[k / kPatchSize].Add(p, w);
    columns[k % kPatchSize].Add(p, w);
  }
  const float least_variance = std::max(kTexture * noise2, kLeastVariance);
  float least = 1;
  for (const auto& lines : {rows, columns}) {
    least = std::min(least, NccOf(lines[0], lines[1], lines[2], least_variance));
    least = std::min(least, NccOf(lines[2], lines[3], lines[4], least_variance));
  }
  return least;
}

bool SideCheck::Passes(const ReferenceFrame& reference, const EndedSeed& ended) const {
  if (options_.min_side_ncc <= -1) return true;
  const SeedState& seed = ended.seed;
  const double bx = seed.bearing_x, by = seed.bearing_y;
  const auto depth = static_cast<double>(
      DepthOf<float>(options_.coordinate, seed.interval, seed.posterior.mu, 0).depth);
  const double z_depth = depth / std::sqrt(bx * bx + by * by + 1);
  const auto grid = GridOf(reference, cam_from_world_, projector_, bx, by, z_depth);
  if (!grid) return true;
  const auto window = Sample(pyramid_[reference.level], *grid);
  if (!window) return true;
  PatchValues patch;
  std::copy(std::begin(ended.patch), std::end(ended.patch), patch.begin());
  const float noise2 = NoiseVariance(options_, reference.level);
  return LeastSideNcc(patch, *window, noise2) >= options_.min_side_ncc;
}

}  // namespace livemvs
