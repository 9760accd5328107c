#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "csv.h"
#include "experiments.h"
#include "livemvs/synth/random.h"

namespace livemvs::experiments {
namespace {

struct Kind {
  const char* name;
  // Of the sensor and of its surface's material.
  bool (*fits)(const PixelSensor& sensor, bool textureless);
};

constexpr Kind kKinds[] = {
    {"textured",
     [](const PixelSensor& s, bool) { return s.visible_share > 0.97 && s.ray.Contrast() > 15; }},
    {"untextured",
     [](const PixelSensor& s, bool plain) {
       return plain && s.visible_share > 0.8 && s.ray.Contrast() < 2 * kNoise;
     }},
    {"occluded",
     [](const PixelSensor& s, bool plain) {
       return !plain && s.visible_share < 0.2 && s.ray.Contrast() > 15;
     }},
};

bool IsPlain(const SyntheticScene& scene, const PixelSensor& sensor) {
  SyntheticScene::Hit hit;
  return scene.Intersect(sensor.ray.origin, sensor.ray.direction, &hit) &&
         scene.materials()[scene.MaterialOf(hit.face)].textureless;
}

// All pixels of the first photo on a grid, with what their neighbours see, unobserved.
std::vector<PixelSensor> Candidates(const SyntheticScene& scene,
                                    const PhotoSet& photos,
                                    const std::vector<int>& neighbours) {
  std::vector<PixelSensor> candidates;
  const Camera& camera = photos.views[0].projector.camera();
  for (int y = 4; y < camera.height - 4; y += 2) {
    for (int x = 4; x < camera.width - 4; x += 2) {
      auto sensor = PlaceSensor(photos, &scene, 0, x, y);
      if (!sensor) continue;
      sensor->visible_share = VisibleShare(photos, scene, neighbours, *sensor);
      candidates.push_back(*std::move(sensor));
    }
  }
  return candidates;
}

struct Judged {
  PixelSensor sensor;
  Posterior<double> q{};
};

// Up to 200 candidates of a kind, drawn at random, by inlier ratio.
std::vector<Judged> JudgeSome(const Kind& kind,
                              const SyntheticScene& scene,
                              const PhotoSet& photos,
                              const std::vector<int>& neighbours,
                              const std::vector<PixelSensor>& candidates) {
  std::vector<Judged> judged;
  synth::Random random(1);
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1],
              order[static_cast<std::size_t>(random.Uniform() * static_cast<double>(i))]);
  }
  for (const std::size_t i : order) {
    if (judged.size() == 200) break;
    if (kind.fits(candidates[i], IsPlain(scene, candidates[i]))) judged.push_back({candidates[i]});
  }
  tbb::parallel_for(std::size_t{0}, judged.size(), [&](std::size_t i) {
    PixelSensor& sensor = judged[i].sensor;
    Observe(photos, neighbours, &sensor);
    Measure(Selection::kLargest, &sensor);
    const auto count = static_cast<int>(sensor.measurements.size());
    judged[i].q = UpdateInTurn(sensor, PriorOf(sensor, kPrior, kPrior), count);
  });
  std::sort(judged.begin(), judged.end(), [](const Judged& a, const Judged& b) {
    return InlierRatio(a.q) < InlierRatio(b.q);
  });
  return judged;
}

}  // namespace

void SensorKinds(const Settings& settings, const PixelSet& video) {
  const SyntheticScene& scene = video.scene;
  const PhotoSet& photos = video.photos;
  std::vector<int> neighbours(photos.views.size() - 1);
  std::iota(neighbours.begin(), neighbours.end(), 1);
  const std::vector<PixelSensor> candidates = Candidates(scene, photos, neighbours);
  Csv states(settings.tables / "fig5_states.csv",
             "kind,pixels,inlier ratio 10 %,median,90 %,shown: mu [mm],sigma [mm],inlier ratio,"
             "visible share,contrast,true depth [mm],Zmin [mm],Zmax [mm]");
  Csv measurements(settings.tables / "fig5_measurements.csv", "kind,depth [mm],tau [mm]");
  for (const Kind& kind : kKinds) {
    const auto judged = JudgeSome(kind, scene, photos, neighbours, candidates);
    if (judged.empty()) continue;
    const auto ratio = [&](std::size_t percent) {
      return InlierRatio(judged[(judged.size() - 1) * percent / 100].q);
    };
    const auto& [sensor, q] = judged[(judged.size() - 1) / 2];  // the median one is shown
    states.Row(kind.name,
               judged.size(),
               ratio(10),
               ratio(50),
               ratio(90),
               kMillimetres * q.mu,
               kMillimetres * std::sqrt(q.sigma2),
               InlierRatio(q),
               sensor.visible_share,
               sensor.ray.Contrast(),
               kMillimetres * sensor.z_true,
               kMillimetres * sensor.z_min,
               kMillimetres * sensor.z_max);
    for (const auto& m : sensor.measurements) {
      measurements.Row(kind.name, kMillimetres * m.x, kMillimetres * std::sqrt(m.tau2));
    }
  }
}

}  // namespace livemvs::experiments
