#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "csv.h"
#include "experiments.h"
#include "livemvs/io/dataset.h"
#include "livemvs/reference/depth_histogram.h"

namespace livemvs::experiments {
namespace {

// What makes a pixel worth showing: texture, and a stretch of ray to search. [grey levels]
constexpr double kContrast = 12, kTempleContrast = 8;

// Darkest grey level of the plaster; the background is black.
constexpr double kBlack = 40;

// Views of the ring are 7.6 degrees apart: beyond four on each side a patch looks too different.
constexpr int kTempleNeighbours = 8;

// Curves that are drawn one by one, from near to far neighbours.
constexpr int kCurves = 4;

void Write(const Settings& settings,
           const std::string& name,
           const PhotoSet& photos,
           const PixelSensor& sensor,
           const std::vector<int>& neighbours) {
  Csv curves(settings.tables / (name + "_curves.csv"), "neighbour,depth [mm],NCC");
  Csv maxima(settings.tables / (name + "_maxima.csv"), "neighbour,depth [mm],NCC,tau [mm]");
  const auto step = std::max<std::size_t>(1, neighbours.size() / kCurves);
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const auto curve =
        reference::TraceNcc(sensor.ray, photos.views[neighbours[i]], sensor.z_min, sensor.z_max);
    for (const auto& m : curve.maxima) {
      maxima.Row(i, kMillimetres * m.depth, m.score, kMillimetres * m.depth_per_px);
    }
    if (i % step != step / 2) continue;
    for (std::size_t k = 0; k < curve.depths.size(); ++k) {
      curves.Row(i, kMillimetres * curve.depths[k], curve.scores[k]);
    }
  }
  Csv pixel(settings.tables / (name + "_pixel.csv"),
            "view,x,y,neighbours,Zmin [mm],Zmax [mm],true depth [mm]");
  const std::string truth =
      sensor.z_true > 0 ? std::to_string(kMillimetres * sensor.z_true) : std::string();
  pixel.Row(sensor.view,
            sensor.x,
            sensor.y,
            neighbours.size(),
            kMillimetres * sensor.z_min,
            kMillimetres * sensor.z_max,
            truth);
}

// A good pixel of the plaster: with texture and not at its edge, where the black background is
// in the patch. Of many, by the votes of the fullest bin, the one at nine tenths.
std::optional<PixelSensor> FindGood(const PhotoSet& photos,
                                    int view,
                                    const std::vector<int>& neighbours) {
  const Camera& camera = photos.views[view].projector.camera();
  std::vector<std::pair<int, PixelSensor>> by_votes;
  for (int y = camera.height / 4; y < 3 * camera.height / 4; y += 8) {
    for (int x = camera.width / 4; x < 3 * camera.width / 4; x += 8) {
      auto sensor = PlaceSensor(photos, nullptr, view, x, y);
      if (!sensor || sensor->ray.Contrast() < kTempleContrast) continue;
      const std::vector<double>& patch = sensor->ray.patch;
      if (*std::min_element(patch.begin(), patch.end()) < kBlack) continue;
      Observe(photos, neighbours, &*sensor);
      reference::DepthHistogram histogram(sensor->z_min, sensor->z_max, 100);
      for (const auto& m : sensor->measurements) histogram.Vote(m.x);
      int most = 0;
      for (int i = 0; i < histogram.bins(); ++i) most = std::max(most, histogram.votes(i));
      by_votes.emplace_back(most, *std::move(sensor));
    }
  }
  if (by_votes.empty()) return std::nullopt;
  std::stable_sort(by_votes.begin(), by_votes.end(), [](const auto& a, const auto& b) {
    return a.first < b.first;
  });
  return by_votes[by_votes.size() * 9 / 10].second;
}

void Temple(const Settings& settings) {
  if (settings.temple.empty()) {
    std::fprintf(stderr, "temple ring: not there, left out\n");
    return;
  }
  const auto dataset = OpenDataset({.data = settings.temple});
  const PhotoSet photos = ReadPhotos(dataset.get());
  const int view = static_cast<int>(photos.views.size()) / 4;
  const std::vector<int> neighbours = NearestViews(photos, view, kTempleNeighbours);
  const auto sensor = FindGood(photos, view, neighbours);
  if (sensor) {
    Write(settings, "fig2_temple", photos, *sensor, neighbours);
  } else {
    std::fprintf(stderr, "temple ring: no texture in the middle of the picture, left out\n");
  }
}

}  // namespace

void NccCurves(const Settings& settings, const PixelSet& relief) {
  Temple(settings);
  const PixelSensor& sensor = relief.Find([](const PixelSensor& s) {
    return s.visible_share > 0.9 && s.ray.Contrast() > kContrast && s.range() > 0.12;
  });
  Write(settings, "fig2", relief.photos, sensor, NearestViews(relief.photos, sensor.view, 60));
}

}  // namespace livemvs::experiments
