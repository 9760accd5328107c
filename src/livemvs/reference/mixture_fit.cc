#include "livemvs/reference/mixture_fit.h"

#include <cmath>
#include <numbers>

namespace livemvs::reference {
namespace {

constexpr int kMostIterations = 2000;
// EM stops when an iteration gains less log-likelihood than this.
constexpr double kGain = 1e-10;

double Normal(double x, double mean, double variance) {
  const double d = x - mean;
  return std::exp(-d * d / (2 * variance)) / std::sqrt(2 * std::numbers::pi * variance);
}

}  // namespace

double MixtureLogLikelihood(std::span<const DepthMeasurement> measurements,
                            double u,
                            double z,
                            double inlier_ratio) {
  double sum = 0;
  for (const DepthMeasurement& m : measurements) {
    sum += std::log(inlier_ratio * Normal(m.x, z, m.tau2) + (1 - inlier_ratio) * u);
  }
  return sum;
}

MixtureFit FitMixtureByEm(std::span<const DepthMeasurement> measurements,
                          double u,
                          const MixtureFit& start) {
  MixtureFit fit = start;
  fit.iterations = 0;
  fit.log_likelihood = MixtureLogLikelihood(measurements, u, fit.z, fit.inlier_ratio);
  if (measurements.empty()) return fit;
  while (fit.iterations < kMostIterations) {
    double sum_r = 0, sum_weight = 0, sum_weighted_x = 0;
    for (const DepthMeasurement& m : measurements) {
      // E: the probability that the measurement is a good one.
      const double good = fit.inlier_ratio * Normal(m.x, fit.z, m.tau2);
      const double r = good / (good + (1 - fit.inlier_ratio) * u);
      // M: weighted least squares for Z, a mean for pi.
      sum_r += r;
      sum_weight += r / m.tau2;
      sum_weighted_x += r * m.x / m.tau2;
    }
    // Far from all measurements the responsibilities underflow, and Z has nowhere to go.
    if (sum_weight > 0) fit.z = sum_weighted_x / sum_weight;
    fit.inlier_ratio = sum_r / static_cast<double>(measurements.size());
    const double before = fit.log_likelihood;
    fit.log_likelihood = MixtureLogLikelihood(measurements, u, fit.z, fit.inlier_ratio);
    ++fit.iterations;
    if (fit.log_likelihood - before < kGain) break;
  }
  return fit;
}

}  // namespace livemvs::reference
