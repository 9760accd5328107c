#include "relief.h"

#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <optional>
#include <utility>

#include "livemvs/synth/random.h"

namespace livemvs::experiments {
namespace {

// As in [VH11] Fig. 2b.
constexpr int kNeighbours = 60;

constexpr double kNoise = 2;  // [grey levels]
constexpr int kBorder = 4;    // of the picture [px]

bool IsStone(const SyntheticScene& scene, const PixelSensor& sensor) {
  SyntheticScene::Hit hit;
  return scene.Intersect(sensor.ray.origin, sensor.ray.direction, &hit) &&
         scene.materials()[scene.MaterialOf(hit.face)].name == "sandstone";
}

// A pixel of the temple, evenly distributed over its pixels in all views.
PixelSensor DrawSensor(const SyntheticScene& scene, const PhotoSet& photos, std::uint64_t seed) {
  synth::Random random(seed);
  while (true) {
    const auto view = static_cast<int>(random.Uniform(0, static_cast<double>(photos.views.size())));
    const Camera& camera = photos.views[view].projector.camera();
    const auto x = static_cast<int>(random.Uniform(kBorder, camera.width - kBorder));
    const auto y = static_cast<int>(random.Uniform(kBorder, camera.height - kBorder));
    auto sensor = PlaceSensor(photos, &scene, view, x, y);
    if (sensor && IsStone(scene, *sensor)) return *std::move(sensor);
  }
}

}  // namespace

const PixelSensor& Relief::Find(const std::function<bool(const PixelSensor&)>& fits) const {
  const auto found = std::find_if(sensors.begin(), sensors.end(), fits);
  return found == sensors.end() ? sensors.front() : *found;
}

void ShowProgress(const char* what, int done, int all) {
  // Ten lines for a log, a running count for a person.
  static const bool person = isatty(fileno(stderr)) != 0;
  const int lines = person ? 100 : 10;
  const bool last = done == all;
  if (!last && static_cast<std::int64_t>(done) * lines / all ==
                   static_cast<std::int64_t>(done - 1) * lines / all) {
    return;
  }
  std::fprintf(
      stderr, "%s%s: %d of %d%s", person ? "\r" : "", what, done, all, person && !last ? "" : "\n");
}

Relief MakeRelief(bool quick) {
  SequenceOptions sequence;
  sequence.path = DefaultPath("relief");
  if (quick) {
    sequence.camera = SyntheticCamera(160, 120);
    sequence.path.frames = 80;
  }
  sequence.noise_sigma = kNoise;
  sequence.ground_truth = false;
  SyntheticScene scene({.name = "relief"});
  PhotoSet photos = RenderPhotos(scene, sequence, 0, sequence.path.frames, [](int done, int all) {
    ShowProgress("views of the relief", done, all);
  });
  std::vector<PixelSensor> sensors(quick ? 100 : 1500);
  std::atomic<int> done = 0;
  tbb::parallel_for(std::size_t{0}, sensors.size(), [&](std::size_t i) {
    PixelSensor sensor = DrawSensor(scene, photos, i);
    const std::vector<int> neighbours = NearestViews(photos, sensor.view, kNeighbours);
    sensor.visible_share = VisibleShare(photos, scene, neighbours, sensor);
    Observe(photos, neighbours, &sensor);
    sensors[i] = std::move(sensor);
    ShowProgress("pixels of the relief", ++done, static_cast<int>(sensors.size()));
  });
  return {std::move(scene), std::move(photos), std::move(sensors)};
}

}  // namespace livemvs::experiments
