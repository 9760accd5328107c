#include "livemvs/reference/side_check.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "livemvs/reference/matcher.h"

namespace livemvs::reference {
namespace {

// What the current picture shows at the places of the patch's pixels; none where one is outside.
std::optional<std::array<double, kPatchPixels>> WindowOf(const Options& options,
                                                         const Seed& seed,
                                                         const Meeting& current) {
  const Projector ref(seed.camera);
  const Eigen::Vector3d ray(seed.bearing_x, seed.bearing_y, 1);
  const auto center = ref.Project(ray);
  if (!center) return std::nullopt;
  const double z = DepthAt(options, seed, seed.posterior.mu) / ray.norm();
  std::array<double, kPatchPixels> window{};
  for (int i = 0; i < kPatchPixels; ++i) {
    const Eigen::Vector2d step(i % kPatchSize - kPatchRadius, i / kPatchSize - kPatchRadius);
    const auto beside = ref.Unproject(*center + step);
    if (!beside) return std::nullopt;
    const Eigen::Vector3d world = seed.cam_from_world.Inverse() * Eigen::Vector3d(*beside * z);
    const auto pixel = current.projector.Project(current.cam_from_world * world);
    if (!pixel || !current.projector.camera().Contains(*pixel, 1)) return std::nullopt;
    window[i] = Bilinear(current.image, *pixel);
  }
  return window;
}

// NCC over the pixels for which `inside` holds; 1 where the patch varies too little there.
template <typename Inside>
double NccWhere(const Seed& seed,
                const std::array<double, kPatchPixels>& window,
                double least_variance,
                const Inside& inside) {
  std::vector<double> p, w;
  for (int i = 0; i < kPatchPixels; ++i) {
    if (!inside(i % kPatchSize - kPatchRadius, i / kPatchSize - kPatchRadius)) continue;
    p.push_back(seed.patch[i]);
    w.push_back(window[i]);
  }
  Eigen::Map<Eigen::ArrayXd> patch(p.data(), static_cast<int>(p.size()));
  Eigen::Map<Eigen::ArrayXd> other(w.data(), static_cast<int>(w.size()));
  patch -= patch.mean();
  other -= other.mean();
  if (!(patch.square().mean() > least_variance)) return 1;
  const double window_variance = std::max(other.square().mean(), 0.5);
  return (patch * other).mean() / std::sqrt(patch.square().mean() * window_variance);
}

}  // namespace

bool SidesMatch(const Options& options, const Seed& seed, const Meeting& current) {
  if (options.min_side_ncc <= -1) return true;
  const auto window = WindowOf(options, seed, current);
  if (!window) return true;
  const double noise = std::ldexp(options.image_noise, -current.level);
  const double least_variance = std::max(8 * noise * noise, 0.5);
  const auto matches = [&](const auto& inside) {
    return NccWhere(seed, *window, least_variance, inside) >= options.min_side_ncc;
  };
  return matches([](int x, int) { return x <= 0; }) && matches([](int x, int) { return x >= 0; }) &&
         matches([](int, int y) { return y <= 0; }) && matches([](int, int y) { return y >= 0; });
}

}  // namespace livemvs::reference
