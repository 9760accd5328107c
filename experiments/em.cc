#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include "csv.h"
#include "experiments.h"
#include "livemvs/synth/random.h"

namespace livemvs::experiments {
namespace {

constexpr std::size_t kPixels = 2000;
constexpr int kRestarts = 10;

// An estimate is elsewhere than the maximum if it is further off than this share of the range.
constexpr double kElsewhere = 0.01;

// Depths found by each way, in the order of kNames.
constexpr const char* kNames[] = {"EM from the middle of the range",
                                  "EM from one random start",
                                  "EM from the best of 10 random starts",
                                  "sequential parametric update"};
constexpr std::size_t kWays = std::size(kNames);

struct Found {
  double range = 0, global = 0, truth = 0;
  double z[kWays] = {};
  double inlier_ratio[kWays] = {};
};

// From half of the measurements being good, anywhere.
reference::MixtureFit Em(const PixelSensor& sensor, double share_of_range) {
  return reference::FitMixtureByEm(
      sensor.measurements,
      sensor.u(),
      {.z = sensor.z_min + share_of_range * sensor.range(), .inlier_ratio = 0.5});
}

Found Search(const PixelSensor& sensor, std::uint64_t seed) {
  const auto count = static_cast<int>(sensor.measurements.size());
  Found found{.range = sensor.range(), .truth = sensor.z_true};
  reference::MixtureFit global = ClimbFrom(sensor, DenseAfter(sensor, 500, 100, count));
  const auto keep = [&](std::size_t way, const reference::MixtureFit& fit) {
    found.z[way] = fit.z;
    found.inlier_ratio[way] = fit.inlier_ratio;
    if (fit.log_likelihood > global.log_likelihood) global = fit;
  };
  keep(0, Em(sensor, 0.5));
  synth::Random random(seed);
  reference::MixtureFit best = Em(sensor, random.Uniform());
  keep(1, best);
  for (int i = 1; i < kRestarts; ++i) {
    const reference::MixtureFit fit = Em(sensor, random.Uniform());
    if (fit.log_likelihood > best.log_likelihood) best = fit;
  }
  keep(2, best);
  const Posterior<double> q = UpdateInTurn(sensor, PriorOf(sensor, kPrior, kPrior), count);
  found.z[3] = q.mu;
  found.inlier_ratio[3] = InlierRatio(q);
  found.global = global.z;
  return found;
}

}  // namespace

void LocalOptima(const Settings& settings, const PixelSet& relief) {
  std::vector<Found> all(std::min(kPixels, relief.sensors.size()));
  std::atomic<int> done = 0;
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    all[i] = Search(relief.sensors[i], i);
    ShowProgress("local optima", ++done, static_cast<int>(all.size()));
  });
  Csv csv(settings.tables / "em.csv",
          "way,pixels,not at the global maximum,wrong depth,"
          "median inlier ratio at the maximum,elsewhere");
  for (std::size_t way = 0; way < kWays; ++way) {
    std::vector<double> there, elsewhere;
    int wrong = 0;
    for (const Found& f : all) {
      const double near = kElsewhere * f.range;
      (std::abs(f.z[way] - f.global) > near ? elsewhere : there).push_back(f.inlier_ratio[way]);
      wrong += std::abs(f.z[way] - f.truth) > near ? 1 : 0;
    }
    const auto median = [](std::vector<double>& v) {
      if (v.empty()) return 0.0;
      std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
      return v[v.size() / 2];
    };
    const auto n = static_cast<double>(all.size());
    csv.Row(kNames[way],
            all.size(),
            static_cast<double>(elsewhere.size()) / n,
            wrong / n,
            median(there),
            median(elsewhere));
  }
  double wrong = 0;
  for (const Found& f : all) wrong += std::abs(f.global - f.truth) > kElsewhere * f.range ? 1 : 0;
  csv.Row("global maximum", all.size(), 0.0, wrong / static_cast<double>(all.size()), "", "");
}

}  // namespace livemvs::experiments
