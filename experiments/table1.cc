#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
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

// [VH11] Sec. 3.1.
constexpr int kZBins = 500, kPiBins = 100;

// [VH11] Sec. 4.2.
constexpr double kPrior = 10;

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
  methods.push_back({"Gauss+Uniform parametric", {}, {}});
  for (Method& m : methods) {
    m.to_surface.resize(pixels);
    m.along_ray.resize(pixels);
  }
  return methods;
}

// The depth of each method. Without measurements all fall back to the middle of the range.
std::vector<double> Estimate(const PixelSensor& sensor) {
  const auto count = static_cast<int>(sensor.measurements.size());
  std::vector<double> depths;
  for (const int bins : kBins) {
    depths.push_back(VoteForDepth(sensor, bins).value_or((sensor.z_min + sensor.z_max) / 2));
  }
  const reference::DensePosterior dense = DenseAfter(sensor, kZBins, kPiBins, count);
  depths.push_back(dense.ModeOfZ());
  depths.push_back(ClimbFrom(sensor, dense).z);
  depths.push_back(UpdateInTurn(sensor, PriorOf(sensor, kPrior, kPrior), count).mu);
  return depths;
}

}  // namespace

void Table1(const Settings& settings, const Relief& relief) {
  const MeshSurface surface(relief.scene.mesh());
  std::vector<Method> methods = Methods(relief.sensors.size());
  std::atomic<int> done = 0;
  tbb::parallel_for(std::size_t{0}, relief.sensors.size(), [&](std::size_t i) {
    const PixelSensor& sensor = relief.sensors[i];
    const std::vector<double> depths = Estimate(sensor);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      methods[m].to_surface[i] = static_cast<float>(surface.Distance(sensor.ray.At(depths[m])));
      methods[m].along_ray[i] = static_cast<float>(std::abs(depths[m] - sensor.z_true));
    }
    ShowProgress("table 1", ++done, static_cast<int>(relief.sensors.size()));
  });
  const auto write = [&](const char* name, std::vector<float> Method::*errors) {
    Csv csv(settings.tables / name, "method,50 % [mm],80 %,85 %,90 %,95 %,100 %");
    for (Method& m : methods) {
      std::vector<float>& e = m.*errors;
      std::sort(e.begin(), e.end());
      const auto at = [&](double q) { return kMillimetres * Percentile(e, q).value_or(0); };
      csv.Row(m.name, at(50), at(80), at(85), at(90), at(95), at(100));
    }
  };
  write("table1.csv", &Method::to_surface);
  write("table1_along_ray.csv", &Method::along_ray);
  Csv csv(settings.tables / "table1_pixels.csv",
          "pixels,views,mean measurements,mean visible share");
  double measurements = 0, visible = 0;
  const auto n = static_cast<double>(relief.sensors.size());
  for (const PixelSensor& s : relief.sensors) {
    measurements += static_cast<double>(s.measurements.size()) / n;
    visible += s.visible_share / n;
  }
  csv.Row(relief.sensors.size(), relief.photos.views.size(), measurements, visible);
}

}  // namespace livemvs::experiments
