#include "livemvs/synth/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "livemvs/parallel/parallel_for.h"
#include "livemvs/synth/random.h"

namespace livemvs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// Rays of a camera. Distortion is solved once per corner of the pixel grid, not once per sample.
class RayGrid {
 public:
  explicit RayGrid(const Camera& camera) : projector_(camera) {}

  /// Rays through the corners (i - 0.5, y - 0.5) of a row of pixels.
  std::vector<std::optional<Vector3d>> Corners(double y) const {
    std::vector<std::optional<Vector3d>> rays(projector_.camera().width + 1);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      rays[i] = projector_.Unproject({static_cast<double>(i) - 0.5, y - 0.5});
    }
    return rays;
  }

  std::optional<Vector3d> Center(int x, int y) const {
    return projector_.Unproject(Vector2d(x, y));
  }

 private:
  Projector projector_;
};

// Places of the samples in a pixel, [0, 1)²: a lattice that is stratified in x and in y.
std::vector<Vector2d> SamplePattern(int count) {
  std::vector<Vector2d> pattern;
  for (int i = 0; i < count; ++i) {
    const double golden = 0.5 + i * (std::numbers::phi - 1);
    pattern.emplace_back((i + 0.5) / count, golden - std::floor(golden));
  }
  return pattern;
}

struct Shot {
  const SyntheticScene& scene;
  const Camera& camera;
  const FrameRenderOptions& options;
  RayGrid rays;
  Rigid3d world_from_cam;
  std::vector<Rigid3d> shutter;  // world_from_cam, one or more
  std::vector<Vector2d> pattern;
  float pixel_angle;  // of a pixel at the axis, relative to depth
};

// The light that arrives along a ray from what it met.
Vector3f Shade(const Shot& shot, const SyntheticScene::Ray& ray, const SyntheticScene::Hit& hit) {
  const Vector3f direction = ray.direction.cast<float>();
  if (hit.face < 0) return shot.scene.Background(direction.normalized());
  // A pixel covers a longer piece of a slanted surface; the square root is between its two sides.
  const float slant = std::abs(shot.scene.FaceNormal(hit.face).dot(direction)) / direction.norm();
  const float footprint =
      static_cast<float>(hit.distance) * shot.pixel_angle / std::sqrt(std::max(slant, 0.1f));
  return shot.scene.Radiance(hit, direction.normalized(), footprint);
}

// A row's samples: those of pixel x are the `pattern.size()` rays from first[x], none where the
// camera sees nothing there.
struct RowRays {
  std::vector<SyntheticScene::Ray> rays;
  std::vector<std::size_t> first;
};

RowRays SampleRow(const Shot& shot, int y) {
  const auto above = shot.rays.Corners(y), below = shot.rays.Corners(y + 1);
  RowRays row;
  row.rays.reserve(shot.camera.width * shot.pattern.size());
  row.first.reserve(shot.camera.width + 1);
  for (int x = 0; x < shot.camera.width; ++x) {
    row.first.push_back(row.rays.size());
    if (!above[x] || !above[x + 1] || !below[x] || !below[x + 1]) continue;
    for (std::size_t s = 0; s < shot.pattern.size(); ++s) {
      const Vector2d& at = shot.pattern[s];
      const Vector3d ray = (1 - at.y()) * ((1 - at.x()) * *above[x] + at.x() * *above[x + 1]) +
                           at.y() * ((1 - at.x()) * *below[x] + at.x() * *below[x + 1]);
      const Rigid3d& world_from_cam = shot.shutter[s % shot.shutter.size()];
      row.rays.push_back({world_from_cam.translation, world_from_cam.rotation * ray});
    }
  }
  row.first.push_back(row.rays.size());
  return row;
}

// Two independent normal deviates that depend on the key alone.
std::array<float, 2> Normals(std::uint64_t key) {
  const std::uint64_t bits = synth::Mix(key);
  const float u = (static_cast<float>(bits >> 40) + 0.5f) * 0x1.0p-24f;
  const float angle =
      2.f * std::numbers::pi_v<float> * static_cast<float>(bits >> 16 & 0xFFFFFF) * 0x1.0p-24f;
  const float radius = std::sqrt(-2.f * std::log(u));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

std::uint8_t ToByte(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.f, 255.f)));
}

// Luma and chroma (BT.601, full range) with sensor noise.
void StorePixel(
    const Vector3f& light, std::uint64_t key, double sigma, Picture* out, int x, int y) {
  const float r = synth::ToSrgbLevel(light.x());
  const float g = synth::ToSrgbLevel(light.y());
  const float b = synth::ToSrgbLevel(light.z());
  float luma = 0.299f * r + 0.587f * g + 0.114f * b;
  float cb = 128.f + (b - luma) / 1.772f, cr = 128.f + (r - luma) / 1.402f;
  if (sigma > 0) {
    const auto chroma_noise = Normals(synth::Mix(key));
    const float s = static_cast<float>(sigma);
    luma += s * Normals(key)[0];
    cb += 0.5f * s * chroma_noise[0];
    cr += 0.5f * s * chroma_noise[1];
  }
  out->grey(x, y) = ToByte(luma);
  out->cb(x, y) = ToByte(cb);
  out->cr(x, y) = ToByte(cr);
}

void RenderTruth(const Shot& shot, int x, int y, RenderedFrame* out) {
  out->material(x, y) = RenderedFrame::kNoMaterial;
  const auto center = shot.rays.Center(x, y);
  SyntheticScene::Hit hit;
  if (center &&
      shot.scene.Intersect(
          shot.world_from_cam.translation, shot.world_from_cam.rotation * *center, &hit)) {
    // The ray's z is 1, so that its parameter is the depth along the axis.
    out->z_depth(x, y) = static_cast<float>(hit.distance);
    out->material(x, y) = shot.scene.MaterialOf(hit.face);
  }
}

void RenderRow(const Shot& shot, std::int64_t frame_index, int y, RenderedFrame* out) {
  const RowRays row = SampleRow(shot, y);
  std::vector<SyntheticScene::Hit> hits;
  shot.scene.Intersect(row.rays, &hits);
  const std::uint64_t row_key =
      synth::Mix(shot.options.noise_seed + synth::Mix(static_cast<std::uint64_t>(frame_index))) +
      static_cast<std::uint64_t>(y) * 0x10000;
  const float scale =
      static_cast<float>(shot.options.exposure / static_cast<double>(shot.pattern.size()));
  for (int x = 0; x < shot.camera.width; ++x) {
    Vector3f light = Vector3f::Zero();
    for (std::size_t i = row.first[x]; i < row.first[x + 1]; ++i) {
      light += scale * Shade(shot, row.rays[i], hits[i]);
    }
    StorePixel(light, row_key + x, shot.options.noise_sigma, &out->picture, x, y);
    if (shot.options.ground_truth) RenderTruth(shot, x, y, out);
  }
}

}  // namespace

void FrameRenderOptions::Check() const {
  if (samples_per_pixel < 1 || samples_per_pixel > 1024) {
    throw std::invalid_argument("samples_per_pixel must be 1 to 1024");
  }
  if (!(noise_sigma >= 0 && noise_sigma <= 100)) {
    throw std::invalid_argument("noise_sigma must be 0 to 100 grey levels");
  }
  if (!(exposure > 0 && exposure < 1e3)) throw std::invalid_argument("exposure must be positive");
}

RenderedFrame RenderFrame(const SyntheticScene& scene,
                          const Camera& camera,
                          const Rigid3d& cam_from_world,
                          const FrameRenderOptions& options,
                          std::int64_t frame_index) {
  camera.Check();
  options.Check();
  Shot shot{scene,
            camera,
            options,
            RayGrid(camera),
            cam_from_world.Inverse(),
            {},
            SamplePattern(options.samples_per_pixel),
            static_cast<float>(1 / std::sqrt(std::abs(camera.fx * camera.fy)))};
  for (const Rigid3d& pose : options.shutter_poses) shot.shutter.push_back(pose.Inverse());
  if (shot.shutter.empty()) shot.shutter.push_back(shot.world_from_cam);

  RenderedFrame out;
  out.picture.full_range = true;
  out.picture.grey = Image<std::uint8_t>(camera.width, camera.height);
  out.picture.cb = Image<std::uint8_t>(camera.width, camera.height);
  out.picture.cr = Image<std::uint8_t>(camera.width, camera.height);
  if (options.ground_truth) {
    out.z_depth = Image<float>(camera.width, camera.height);
    out.material = Image<std::uint8_t>(camera.width, camera.height);
  }
  ParallelFor(static_cast<std::size_t>(camera.height),
              [&](std::size_t y) { RenderRow(shot, frame_index, static_cast<int>(y), &out); });
  return out;
}

}  // namespace livemvs
