#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "csv.h"
#include "experiments.h"
#include "livemvs/eval/evaluate.h"
#include "livemvs/eval/surface.h"

namespace livemvs::experiments {
namespace {

// Bins of the histogram. What is published does not say how many there were; accuracy depends on
// it, so there is a row for each.
constexpr int kBins[] = {50, 100, 200, 300, 400, 500, 1000};

// tau [px] besides the published 1: what the matches' own scatter would suggest.
constexpr double kFinerTaus[] = {0.5, 0.25};

struct Method {
  std::string name;
  std::vector<float> to_surface;  // distance of the estimated point from the true surface [scene]
  std::vector<float> along_ray;   // error of the depth [scene]
};

std::vector<Method> Methods(std::size_t pixels) {
  std::vector<Method> methods;
  for (const int bins : kBins) methods.push_back({"histogram " + std::to_string(bins), {}, {}});
  methods.push_back({"Gauss+Uniform dense 500x100", {}, {}});
  methods.push_back({"Gauss+Uniform exact maximum", {}, {}});
  for (const double tau_px : kFinerTaus) {
    char name[64];
    std::snprintf(name, sizeof(name), "Gauss+Uniform exact maximum tau %g px", tau_px);
    methods.push_back({name, {}, {}});
  }
  methods.push_back({"Gauss+Uniform parametric", {}, {}});
  methods.push_back({"Gauss+Uniform parametric random order", {}, {}});
  for (Method& m : methods) {
    m.to_surface.resize(pixels);
    m.along_ray.resize(pixels);
  }
  return methods;
}

// The depth of each method. Without measurements all fall back to the middle of the range.
std::vector<double> Estimate(PixelSensor sensor) {
  const auto count = static_cast<int>(sensor.measurements.size());
  std::vector<double> depths;
  for (const int bins : kBins) {
    depths.push_back(VoteForDepth(sensor, bins).value_or((sensor.z_min + sensor.z_max) / 2));
  }
  const reference::DensePosterior dense = DenseAfter(sensor, kZBins, kPiBins, count);
  depths.push_back(dense.ModeOfZ());
  depths.push_back(ClimbFrom(sensor, dense).z);
  for (const double tau_px : kFinerTaus) {
    PixelSensor finer = sensor;
    for (auto& m : finer.measurements) m.tau2 *= tau_px * tau_px;
    depths.push_back(ClimbFrom(finer, DenseAfter(finer, kZBins, kPiBins, count)).z);
  }
  const Posterior<double> prior = PriorOf(sensor, kPrior, kPrior);
  depths.push_back(UpdateInTurn(sensor, prior, count).mu);
  Shuffle(&sensor);
  depths.push_back(UpdateInTurn(sensor, prior, count).mu);
  return depths;
}

// Which maxima of the NCC count, and for how many pixels: the more maxima, the longer it takes.
struct Variant {
  const char* name;
  Selection selection;
  std::size_t pixels;
};
constexpr Variant kVariants[] = {{"table1", Selection::kLargest, 10'000},
                                 {"table1_high", Selection::kHigh, 2000},
                                 {"table1_all", Selection::kAll, 500}};

void WriteErrors(const std::filesystem::path& path,
                 std::vector<Method>* methods,
                 std::vector<float> Method::*errors) {
  Csv csv(path, "method,50 % [mm],80 %,85 %,90 %,95 %,100 %");
  for (Method& m : *methods) {
    std::vector<float>& e = m.*errors;
    std::sort(e.begin(), e.end());
    const auto at = [&](double q) { return kMillimetres * Percentile(e, q).value_or(0); };
    csv.Row(m.name, at(50), at(80), at(85), at(90), at(95), at(100));
  }
}

// Standard deviation [px] of the good measurements about the truth, from the median of their
// distances: those within 3 px are taken for good.
double ScatterInPixels(const std::vector<PixelSensor>& sensors,
                       Selection selection,
                       std::size_t pixels) {
  constexpr double kGood = 3;
  constexpr double kSigmaOfMedian = 1.4826;  // of a Gaussian
  std::vector<float> distances;
  for (std::size_t i = 0; i < pixels; ++i) {
    PixelSensor sensor = sensors[i];
    Measure(selection, &sensor);
    for (const auto& m : sensor.measurements) {
      const double px = std::abs(m.x - sensor.z_true) / std::sqrt(m.tau2);
      if (px < kGood) distances.push_back(static_cast<float>(px));
    }
  }
  std::sort(distances.begin(), distances.end());
  return kSigmaOfMedian * Percentile(distances, 50).value_or(0);
}

void RunVariant(const Settings& settings,
                const PixelSet& relief,
                const MeshSurface& surface,
                const Variant& variant) {
  const std::size_t pixels = std::min(variant.pixels, relief.sensors.size());
  std::vector<Method> methods = Methods(pixels);
  std::vector<double> measurements(pixels);
  std::atomic<int> done = 0;
  tbb::parallel_for(std::size_t{0}, pixels, [&](std::size_t i) {
    PixelSensor sensor = relief.sensors[i];
    Measure(variant.selection, &sensor);
    measurements[i] = static_cast<double>(sensor.measurements.size());
    const std::vector<double> depths = Estimate(sensor);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      methods[m].to_surface[i] = static_cast<float>(surface.Distance(sensor.ray.At(depths[m])));
      methods[m].along_ray[i] = static_cast<float>(std::abs(depths[m] - sensor.z_true));
    }
    ShowProgress(variant.name, ++done, static_cast<int>(pixels));
  });
  const std::string name = variant.name;
  WriteErrors(settings.tables / (name + ".csv"), &methods, &Method::to_surface);
  WriteErrors(settings.tables / (name + "_along_ray.csv"), &methods, &Method::along_ray);
  Csv csv(settings.tables / (name + "_pixels.csv"),
          "pixels,views,mean measurements,mean visible share,scatter of good measurements [px]");
  double sum = 0, visible = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    sum += measurements[i];
    visible += relief.sensors[i].visible_share;
  }
  const auto n = static_cast<double>(pixels);
  csv.Row(pixels,
          relief.photos.views.size(),
          sum / n,
          visible / n,
          ScatterInPixels(relief.sensors, variant.selection, pixels));
}

}  // namespace

void Table1(const Settings& settings, const PixelSet& relief) {
  const MeshSurface surface(relief.scene.mesh());
  for (const Variant& variant : kVariants) RunVariant(settings, relief, surface, variant);
}

}  // namespace livemvs::experiments
