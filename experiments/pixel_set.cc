#include "pixel_set.h"

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

constexpr int kBorder = 4;  // of the picture [px]

bool IsStone(const SyntheticScene& scene, const PixelSensor& sensor) {
  SyntheticScene::Hit hit;
  return scene.Intersect(sensor.ray.origin, sensor.ray.direction, &hit) &&
         scene.materials()[scene.MaterialOf(hit.face)].name == "sandstone";
}

using Fits = bool (*)(const SyntheticScene& scene, const PixelSensor& sensor);

// A pixel that fits, evenly distributed over those of the first `views` views.
PixelSensor DrawSensor(const PixelSet& set, int views, Fits fits, std::uint64_t seed) {
  synth::Random random(seed);
  while (true) {
    const auto view = static_cast<int>(random.Uniform(0, views));
    const Camera& camera = set.photos.views[view].projector.camera();
    const auto x = static_cast<int>(random.Uniform(kBorder, camera.width - kBorder));
    const auto y = static_cast<int>(random.Uniform(kBorder, camera.height - kBorder));
    auto sensor = PlaceSensor(set.photos, &set.scene, view, x, y);
    if (sensor && fits(set.scene, *sensor)) return *std::move(sensor);
  }
}

SequenceOptions Sequence(const std::string& scene, bool quick) {
  SequenceOptions sequence;
  sequence.path = DefaultPath(scene);
  if (quick) sequence.camera = SyntheticCamera(160, 120);
  sequence.noise_sigma = kNoise;
  sequence.ground_truth = false;
  return sequence;
}

PixelSet Render(const std::string& name, const SequenceOptions& sequence) {
  SyntheticScene scene({.name = name});
  const std::string what = "views of the " + name;
  PhotoSet photos = RenderPhotos(
      scene, sequence, [&what](int done, int all) { ShowProgress(what.c_str(), done, all); });
  return {std::move(scene), std::move(photos), {}};
}

// Draws sensors and observes them.
void Fill(PixelSet* set, std::size_t count, int views, Fits fits, Selection selection) {
  set->sensors.resize(count);
  std::atomic<int> done = 0;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    PixelSensor sensor = DrawSensor(*set, views, fits, i);
    // Of one view alone: the frames that follow it, in order.
    std::vector<int> neighbours;
    if (views > 1) {
      neighbours = NearestViews(set->photos, sensor.view, kNeighbours);
    } else {
      for (std::size_t k = 1; k < set->photos.views.size(); ++k)
        neighbours.push_back(static_cast<int>(k));
    }
    sensor.visible_share = VisibleShare(set->photos, set->scene, neighbours, sensor);
    Observe(set->photos, neighbours, &sensor);
    Measure(selection, &sensor);
    set->sensors[i] = std::move(sensor);
    ShowProgress("pixels", ++done, static_cast<int>(count));
  });
}

}  // namespace

const PixelSensor& PixelSet::Find(const std::function<bool(const PixelSensor&)>& fits) const {
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

PixelSet MakeRelief(bool quick) {
  SequenceOptions sequence = Sequence("relief", quick);
  if (quick) sequence.path.frames = 80;
  PixelSet set = Render("relief", sequence);
  Fill(&set, quick ? 100 : 10'000, sequence.path.frames, IsStone, Selection::kLargest);
  return set;
}

PixelSet MakeVideo(bool quick) {
  SequenceOptions sequence = Sequence("table", quick);
  sequence.path.arc_deg = 40;
  sequence.path.frames = quick ? 101 : 121;
  PixelSet set = Render("table", sequence);
  const auto any = [](const SyntheticScene&, const PixelSensor&) { return true; };
  Fill(&set, quick ? 100 : 2000, 1, any, Selection::kLargest);
  return set;
}

}  // namespace livemvs::experiments
