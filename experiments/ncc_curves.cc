#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>

#include "csv.h"
#include "experiments.h"
#include "livemvs/io/dataset.h"

namespace livemvs::experiments {
namespace {

// What makes a pixel worth showing: texture, and a stretch of ray to search. [grey levels]
constexpr double kContrast = 12, kTempleContrast = 25;

// Views of the ring are 7.6 degrees apart: beyond four on each side a patch looks too different.
constexpr int kTempleNeighbours = 8;

// Curves that are drawn one by one, from near to far neighbours.
constexpr int kCurves = 6;

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

// A pixel with texture, from the middle of the picture outwards.
std::optional<PixelSensor> FindTexture(const PhotoSet& photos, int view) {
  const Camera& camera = photos.views[view].projector.camera();
  for (int reach = 0; reach < camera.height / 3; reach += 4) {
    for (int dx = -reach; dx <= reach; dx += 4) {
      auto sensor =
          PlaceSensor(photos, nullptr, view, camera.width / 2 + dx, camera.height / 2 - reach);
      if (sensor && sensor->ray.Contrast() > kTempleContrast) return sensor;
    }
  }
  return std::nullopt;
}

void Temple(const Settings& settings) {
  if (settings.temple.empty()) {
    std::fprintf(stderr, "temple ring: not there, left out\n");
    return;
  }
  const auto dataset = OpenDataset({.data = settings.temple});
  const PhotoSet photos = ReadPhotos(dataset.get());
  const int view = static_cast<int>(photos.views.size()) / 4;
  const auto sensor = FindTexture(photos, view);
  if (!sensor) {
    std::fprintf(stderr, "temple ring: no texture in the middle of the picture, left out\n");
    return;
  }
  Write(settings, "fig2_temple", photos, *sensor, NearestViews(photos, view, kTempleNeighbours));
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
