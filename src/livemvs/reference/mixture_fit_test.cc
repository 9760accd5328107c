#include "livemvs/reference/mixture_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "livemvs/reference/posterior.h"

namespace livemvs::reference {
namespace {

std::vector<DepthMeasurement> Mixture(int count, double z, double tau, double pi, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal(z, tau);
  std::vector<DepthMeasurement> measurements;
  for (int i = 0; i < count; ++i) {
    const double x = uniform(random) < pi ? normal(random) : uniform(random);
    measurements.push_back({x, tau * tau});
  }
  return measurements;
}

TEST(MixtureFitTest, EndsAtTheMaximumOfTheDensePosterior) {
  // With a uniform prior the posterior is the likelihood: an oracle that knows nothing of EM.
  constexpr int kZBins = 500, kPiBins = 200;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto measurements = Mixture(150, 0.37, 0.02, 0.6, seed);
    DensePosterior dense(0, 1, kZBins, kPiBins);
    for (const auto& m : measurements) dense.Update(m.x, m.tau2, 1);
    int z = 0, pi = 0;
    for (int i = 0; i < kZBins; ++i) {
      for (int j = 0; j < kPiBins; ++j) {
        if (dense.Mass(i, j) > dense.Mass(z, pi)) z = i, pi = j;
      }
    }
    const MixtureFit fit = FitMixtureByEm(measurements, 1, {.z = 0.4, .inlier_ratio = 0.5});
    // Half a bin, and the tilt of the ridge within it.
    EXPECT_NEAR(fit.z, dense.Z(z), 1.0 / kZBins) << seed;
    EXPECT_NEAR(fit.inlier_ratio, dense.Pi(pi), 1.5 / kPiBins) << seed;
  }
}

TEST(MixtureFitTest, LikelihoodIsFlatAtTheEnd) {
  const auto measurements = Mixture(80, 0.6, 0.03, 0.5, 9);
  const MixtureFit fit = FitMixtureByEm(measurements, 1, {.z = 0.55, .inlier_ratio = 0.5});
  const auto at = [&](double z, double pi) { return MixtureLogLikelihood(measurements, 1, z, pi); };
  constexpr double kStep = 1e-5;
  // Against the curvature, n/tau² and n: the gradient of a point off by 1e-4 tau would be ten times
  // this.
  EXPECT_NEAR((at(fit.z + kStep, fit.inlier_ratio) - at(fit.z - kStep, fit.inlier_ratio)), 0, 1e-5);
  EXPECT_NEAR((at(fit.z, fit.inlier_ratio + kStep) - at(fit.z, fit.inlier_ratio - kStep)), 0, 1e-6);
  EXPECT_DOUBLE_EQ(fit.log_likelihood, at(fit.z, fit.inlier_ratio));
  EXPECT_GT(fit.log_likelihood, at(0.55, 0.5));
}

TEST(MixtureFitTest, IsTrappedByASmallClusterNearItsStart) {
  // Twelve measurements at 0.8, and four that agree at 0.2.
  std::vector<DepthMeasurement> measurements;
  for (int i = 0; i < 12; ++i) measurements.push_back({0.8 + 0.001 * (i - 5.5), 1e-4});
  for (int i = 0; i < 4; ++i) measurements.push_back({0.2 + 0.001 * (i - 1.5), 1e-4});
  const MixtureFit trapped = FitMixtureByEm(measurements, 1, {.z = 0.21, .inlier_ratio = 0.5});
  const MixtureFit best = FitMixtureByEm(measurements, 1, {.z = 0.79, .inlier_ratio = 0.5});
  EXPECT_NEAR(trapped.z, 0.2, 1e-3);
  EXPECT_NEAR(best.z, 0.8, 1e-3);
  EXPECT_NEAR(best.inlier_ratio, 0.75, 0.02);
  EXPECT_LT(trapped.log_likelihood, best.log_likelihood);
}

TEST(MixtureFitTest, StaysWhereThereIsNothing) {
  const std::vector<DepthMeasurement> far = {{0.9, 1e-8}, {0.91, 1e-8}};
  const MixtureFit fit = FitMixtureByEm(far, 1, {.z = 0.1, .inlier_ratio = 0.5});
  EXPECT_DOUBLE_EQ(fit.z, 0.1);
  EXPECT_NEAR(fit.inlier_ratio, 0, 1e-12);
  EXPECT_DOUBLE_EQ(FitMixtureByEm({}, 1, {.z = 0.1, .inlier_ratio = 0.4}).inlier_ratio, 0.4);
}

}  // namespace
}  // namespace livemvs::reference
