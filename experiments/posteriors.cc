#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "csv.h"
#include "experiments.h"

namespace livemvs::experiments {
namespace {

// [VH11] Sec. 3.1 and Fig. 3.
constexpr int kUpdates[] = {5, 10, 20, 100};
constexpr int kLast = 100;

// The prior of the parametric posterior: uniform in pi, as the histogram's; kPrior is the paper's.
constexpr double kUniform = 1;

// Estimates agree within this share of the range.
constexpr double kAgree = 0.01;

// Where a sensor stands after kLast updates.
struct Outcome {
  bool dense_right;  // the dense posterior's mode is near the truth
  bool follows;      // the parametric mean is near that mode
  double inlier_ratio;
};

Outcome Judge(const PixelSensor& sensor, double prior) {
  const double mode = DenseAfter(sensor, kZBins, kPiBins, kLast).ModeOfZ();
  const Posterior<double> q = UpdateInTurn(sensor, PriorOf(sensor, prior, prior), kLast);
  const double near = kAgree * sensor.range();
  return {std::abs(mode - sensor.z_true) < near, std::abs(q.mu - mode) < near, InlierRatio(q)};
}

// The dense posterior finds a depth that is not at the picture's edge, among outliers.
bool IsWorthShowing(const PixelSensor& sensor, const Outcome& outcome) {
  const double place = (sensor.z_true - sensor.z_min) / sensor.range();
  return outcome.dense_right && place > 0.15 && place < 0.85 && outcome.inlier_ratio < 0.7;
}

void WriteMap(const Settings& settings, const std::string& name, const auto& density) {
  Csv csv(settings.maps / (name + ".csv"), "Z [share of range],pi,density");
  for (int i = 0; i < kZBins; ++i) {
    for (int j = 0; j < kPiBins; ++j) {
      csv.Row((i + 0.5) / kZBins, (j + 0.5) / kPiBins, density(i, j));
    }
  }
}

double LogParametric(const Posterior<double>& q, double z, double pi) {
  return -(z - q.mu) * (z - q.mu) / (2 * q.sigma2) + (q.a - 1) * std::log(pi) +
         (q.b - 1) * std::log1p(-pi);
}

void WriteCase(const Settings& settings, const std::string& name, const PixelSensor& sensor) {
  Csv states(settings.tables / ("fig3_" + name + ".csv"),
             "updates,mu [mm],sigma [mm],a,b,inlier ratio,dense mode [mm],dense inlier ratio,"
             "true depth [mm],Zmin [mm],Zmax [mm]");
  for (const int n : kUpdates) {
    const reference::DensePosterior dense = DenseAfter(sensor, kZBins, kPiBins, n);
    const Posterior<double> q = UpdateInTurn(sensor, PriorOf(sensor, kUniform, kUniform), n);
    states.Row(n,
               kMillimetres * q.mu,
               kMillimetres * std::sqrt(q.sigma2),
               q.a,
               q.b,
               InlierRatio(q),
               kMillimetres * dense.ModeOfZ(),
               dense.Moments().mean_pi,
               kMillimetres * sensor.z_true,
               kMillimetres * sensor.z_min,
               kMillimetres * sensor.z_max);
    const std::string suffix = name + "_" + std::to_string(n);
    WriteMap(settings, "dense_" + suffix, [&](int i, int j) { return dense.Mass(i, j); });
    WriteMap(settings, "parametric_" + suffix, [&](int i, int j) {
      return std::exp(LogParametric(q, dense.Z(i), dense.Pi(j)) -
                      LogParametric(q, q.mu, std::clamp(InlierRatio(q), 0.01, 0.99)));
    });
  }
  Csv csv(settings.tables / ("fig3_" + name + "_measurements.csv"), "update,depth [mm],tau [mm]");
  for (int i = 0; i < std::min<int>(kLast, static_cast<int>(sensor.measurements.size())); ++i) {
    const reference::DepthMeasurement& m = sensor.measurements[i];
    csv.Row(i + 1, kMillimetres * m.x, kMillimetres * std::sqrt(m.tau2));
  }
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

void WriteStatistics(Csv* csv, double prior, const std::vector<Outcome>& outcomes) {
  std::vector<double> follows, strays;
  for (const Outcome& o : outcomes) {
    if (o.dense_right) (o.follows ? follows : strays).push_back(o.inlier_ratio);
  }
  const auto share = [](std::size_t part, std::size_t all) {
    return all == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(all);
  };
  const std::size_t right = follows.size() + strays.size();
  csv->Row(prior,
           outcomes.size(),
           share(right, outcomes.size()),
           share(follows.size(), right),
           Quantile(follows, 0.05),
           Quantile(follows, 0.5),
           Quantile(strays, 0.5),
           Quantile(strays, 0.95));
}

}  // namespace

void Posteriors(const Settings& settings, const PixelSet& video) {
  std::vector<const PixelSensor*> sensors;
  for (const PixelSensor& s : video.sensors) {
    if (s.measurements.size() >= kLast && sensors.size() < 1000) sensors.push_back(&s);
  }
  Csv csv(settings.tables / "fig3_statistics.csv",
          "a0 = b0,pixels,dense right,of these parametric follows,"
          "inlier ratio where it follows: 5 %,median,where it strays: median,95 %");
  const PixelSensor *success = nullptr, *failure = nullptr;
  for (const double prior : {kUniform, kPrior}) {
    std::vector<Outcome> outcomes(sensors.size());
    std::atomic<int> done = 0;
    tbb::parallel_for(std::size_t{0}, sensors.size(), [&](std::size_t i) {
      outcomes[i] = Judge(*sensors[i], prior);
      ShowProgress("figure 3", ++done, static_cast<int>(sensors.size()));
    });
    WriteStatistics(&csv, prior, outcomes);
    for (std::size_t i = 0; prior == kUniform && i < sensors.size(); ++i) {
      const PixelSensor*& shown = outcomes[i].follows ? success : failure;
      if (shown == nullptr && IsWorthShowing(*sensors[i], outcomes[i])) shown = sensors[i];
    }
  }
  if (success != nullptr) WriteCase(settings, "success", *success);
  if (failure != nullptr) WriteCase(settings, "failure", *failure);
}

}  // namespace livemvs::experiments
