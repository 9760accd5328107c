// The octree point map: a long walk through the synthetic room, whose points are cast from true
// depth, in the order in which an engine would give them.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "livemvs/map/point_map.h"
#include "livemvs/synth/scene.h"

namespace livemvs {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kFocal = 550;

// Points that one frame of a walk adds: every pixel of a strip, with noise along the ray.
void CastFrame(const SyntheticScene& scene, int frame, double noise_px, PointCloud* cloud) {
  std::mt19937 random(static_cast<unsigned>(frame));
  std::normal_distribution<double> noise(0, noise_px);
  const Eigen::Vector3d center = 0.5 * (scene.box().min + scene.box().max);
  const double turn = 0.021 * frame;
  const Eigen::Vector3d eye =
      center + Eigen::Vector3d(0.6 * std::cos(turn), 0.5 * std::sin(turn), 0);
  const double pitch = 0.7 * std::sin(0.37 * frame);
  std::vector<SyntheticScene::Ray> rays;
  const Eigen::Vector3d forward(
      std::cos(turn) * std::cos(pitch), std::sin(turn) * std::cos(pitch), std::sin(pitch));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d down = forward.cross(right);
  for (int y = 0; y < kHeight; y += 2) {
    for (int x = 0; x < kWidth; x += 2) {
      rays.push_back(
          {eye,
           (forward + (x - kWidth / 2) / kFocal * right + (y - kHeight / 2) / kFocal * down)
               .normalized()});
    }
  }
  std::vector<SyntheticScene::Hit> hits;
  scene.Intersect(rays, &hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].face < 0) continue;
    Point point;
    point.footprint = static_cast<float>(hits[i].distance / kFocal);
    const double distance = hits[i].distance + noise(random) * point.footprint;
    point.position = (rays[i].origin + distance * rays[i].direction).cast<float>();
    point.normal = -rays[i].direction.cast<float>();
    point.color = {90, 120, 150};
    point.sigma = static_cast<float>(noise_px) * point.footprint;
    point.inlier_ratio = 0.8F;
    point.views = 12;
    cloud->push_back(point);
  }
}

const std::vector<PointCloud>& Walk() {
  static const std::vector<PointCloud> walk = [] {
    const SyntheticScene scene({.name = "room", .shadows = false});
    std::vector<PointCloud> frames(150);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      CastFrame(scene, static_cast<int>(i), 0.3, &frames[i]);
    }
    return frames;
  }();
  return walk;
}

/// Insertion of 11 million points, of which the map keeps what is not seen twice.
void BM_InsertWalk(benchmark::State& state) {
  const std::vector<PointCloud>& walk = Walk();
  std::size_t inserted = 0;
  for (auto _ : state) {
    PointMap map;
    for (std::size_t i = 0; i < walk.size(); ++i) {
      map.Insert(walk[i], static_cast<std::uint32_t>(i));
      inserted += walk[i].size();
    }
    state.counters["kept"] = static_cast<double>(map.size());
    state.counters["bytes_a_point"] =
        static_cast<double>(map.bytes()) / static_cast<double>(map.size());
  }
  state.counters["points/s"] =
      benchmark::Counter(static_cast<double>(inserted), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_InsertWalk)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The same walk through ten rooms side by side, until the map holds ten million points.
void BM_KeepTenMillion(benchmark::State& state) {
  const std::vector<PointCloud>& walk = Walk();
  constexpr std::size_t kWanted = 10'000'000;
  for (auto _ : state) {
    PointMap map({.cell_px = 1});
    std::size_t inserted = 0;
    for (int room = 0; map.size() < kWanted; ++room) {
      for (const PointCloud& frame : walk) {
        state.PauseTiming();
        PointCloud moved = frame;
        for (Point& p : moved) p.position.x() += 8.0F * static_cast<float>(room);
        state.ResumeTiming();
        map.Insert(moved, 0);
        inserted += moved.size();
        if (map.size() >= kWanted) break;
      }
    }
    state.counters["inserted"] = static_cast<double>(inserted);
    state.counters["kept"] = static_cast<double>(map.size());
    state.counters["megabytes"] = static_cast<double>(map.bytes()) / 1e6;
    state.counters["points/s"] =
        benchmark::Counter(static_cast<double>(inserted), benchmark::Counter::kIsRate);
  }
}
BENCHMARK(BM_KeepTenMillion)->Unit(benchmark::kMillisecond)->Iterations(1)->UseRealTime();

}  // namespace
}  // namespace livemvs
