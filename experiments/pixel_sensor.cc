#include "pixel_sensor.h"

#include <algorithm>
#include <cmath>

#include "livemvs/core/scene_range.h"
#include "livemvs/core/seed.h"
#include "livemvs/reference/depth_histogram.h"
#include "livemvs/synth/random.h"

namespace livemvs::experiments {
namespace {

// Half of the prior's interval in standard deviations: 99 % within.
constexpr double kSigmas99 = 2.5758;

// Shortest stretch of a ray in the box that leaves something to be found, in lengths of its
// diagonal.
constexpr double kShortest = 0.05;

// A camera sees a point where its ray is free for this share of the way.
constexpr double kUnblocked = 1 - 2e-3;

}  // namespace

std::optional<PixelSensor> PlaceSensor(
    const PhotoSet& photos, const SyntheticScene* scene, int view, int x, int y) {
  PixelSensor sensor;
  sensor.view = view;
  sensor.x = x;
  sensor.y = y;
  const reference::PosedView& from = photos.views[view];
  sensor.ray = reference::MakeRayPatch(from, x, y);
  if (sensor.ray.Contrast() == 0) return std::nullopt;
  SceneRange range;
  range.box = photos.box;
  range.near = 1e-3 * (photos.box.max - photos.box.min).norm();
  range.far = 1e6 * range.near;
  const double cosine = from.cam_from_world.rotation.row(2).dot(sensor.ray.direction);
  const auto stretch = range.Along(sensor.ray.origin, sensor.ray.direction, cosine);
  if (!stretch) return std::nullopt;
  std::tie(sensor.z_min, sensor.z_max) = *stretch;
  if (sensor.range() < kShortest * (photos.box.max - photos.box.min).norm()) return std::nullopt;
  if (scene == nullptr) return sensor;
  SyntheticScene::Hit hit;
  if (!scene->Intersect(sensor.ray.origin, sensor.ray.direction, &hit)) return std::nullopt;
  sensor.z_true = hit.distance;
  if (sensor.z_true < sensor.z_min || sensor.z_true > sensor.z_max) return std::nullopt;
  return sensor;
}

void Observe(const PhotoSet& photos, const std::vector<int>& neighbours, PixelSensor* sensor) {
  sensor->maxima.clear();
  for (const int i : neighbours) {
    sensor->maxima.push_back(
        reference::TraceNcc(sensor->ray, photos.views[i], sensor->z_min, sensor->z_max).maxima);
  }
  Measure(Selection::kHigh, sensor);
}

void Measure(Selection selection, PixelSensor* sensor) {
  sensor->measurements.clear();
  for (const std::vector<reference::NccMaximum>& of_view : sensor->maxima) {
    double least = selection == Selection::kHigh ? kMinNcc : -1;
    if (selection == Selection::kLargest) {
      for (const reference::NccMaximum& m : of_view) least = std::max(least, m.score);
    }
    for (const reference::NccMaximum& m : of_view) {
      if (m.score < least) continue;
      sensor->measurements.push_back({m.depth, m.depth_per_px * m.depth_per_px});
    }
  }
}

void Shuffle(PixelSensor* sensor) {
  // Fisher and Yates, with numbers that are the same on every platform.
  const auto id = (static_cast<std::uint64_t>(sensor->view) << 32) +
                  (static_cast<std::uint64_t>(sensor->y) << 16) + sensor->x;
  synth::Random random(synth::Mix(id));
  for (std::size_t i = sensor->measurements.size(); i > 1; --i) {
    const auto j = static_cast<std::size_t>(random.Uniform() * static_cast<double>(i));
    std::swap(sensor->measurements[i - 1], sensor->measurements[j]);
  }
}

double VisibleShare(const PhotoSet& photos,
                    const SyntheticScene& scene,
                    const std::vector<int>& neighbours,
                    const PixelSensor& sensor) {
  const Eigen::Vector3d point = sensor.ray.At(sensor.z_true);
  int seen = 0;
  for (const int i : neighbours) {
    const reference::PosedView& view = photos.views[i];
    const auto pixel = view.projector.Project(view.cam_from_world * point);
    if (!pixel || !view.projector.camera().Contains(*pixel, kPatchRadius)) continue;
    const Eigen::Vector3d eye = view.cam_from_world.Center();
    SyntheticScene::Hit hit;
    if (!scene.Intersect(eye, point - eye, &hit) || hit.distance > kUnblocked) ++seen;
  }
  return neighbours.empty() ? 0 : seen / static_cast<double>(neighbours.size());
}

std::optional<double> VoteForDepth(const PixelSensor& sensor, int bins) {
  reference::DepthHistogram histogram(sensor.z_min, sensor.z_max, bins);
  for (const auto& m : sensor.measurements) histogram.Vote(m.x);
  return histogram.Mode();
}

Posterior<double> PriorOf(const PixelSensor& sensor, double a0, double b0) {
  const double sigma = sensor.range() / 2 / kSigmas99;
  return {(sensor.z_min + sensor.z_max) / 2, sigma * sigma, a0, b0};
}

Posterior<double> UpdateInTurn(const PixelSensor& sensor, Posterior<double> prior, int count) {
  const auto n = std::min<std::size_t>(count, sensor.measurements.size());
  for (std::size_t i = 0; i < n; ++i) {
    const reference::DepthMeasurement& m = sensor.measurements[i];
    prior = Fuse(prior, m.x, m.tau2, sensor.u()).posterior;
  }
  return prior;
}

reference::DensePosterior DenseAfter(const PixelSensor& sensor,
                                     int z_bins,
                                     int pi_bins,
                                     int count) {
  reference::DensePosterior dense(sensor.z_min, sensor.z_max, z_bins, pi_bins);
  const auto n = std::min<std::size_t>(count, sensor.measurements.size());
  for (std::size_t i = 0; i < n; ++i) {
    const reference::DepthMeasurement& m = sensor.measurements[i];
    dense.Update(m.x, m.tau2, sensor.u());
  }
  return dense;
}

reference::MixtureFit ClimbFrom(const PixelSensor& sensor, const reference::DensePosterior& dense) {
  return reference::FitMixtureByEm(sensor.measurements,
                                   sensor.u(),
                                   {.z = dense.ModeOfZ(), .inlier_ratio = dense.Moments().mean_pi});
}

}  // namespace livemvs::experiments
