#include "livemvs/reference/posterior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace livemvs::reference {
namespace {

TEST(DensePosteriorTest, PriorHasItsMoments) {
  DensePosterior dense(-1, 2, 600, 600);
  dense.SetPrior({0.4, 0.01, 10, 10});
  const PosteriorMoments m = dense.Moments();
  EXPECT_NEAR(m.mean_z, 0.4, 1e-12);
  EXPECT_NEAR(m.var_z, 0.01, 1e-12);
  EXPECT_NEAR(m.mean_pi, 0.5, 1e-12);
  EXPECT_NEAR(m.mean_pi2, 10 * 11 / (20.0 * 21), 1e-7);
  const Posterior<double> q = MatchMoments(m);
  EXPECT_NEAR(q.a, 10, 1e-4);
  EXPECT_NEAR(q.b, 10, 1e-4);
}

TEST(DensePosteriorTest, FindsDepthAndInlierRatioOfAMixture) {
  // [VH11] Fig. 3: a uniform prior, and measurements of which 60 % are good.
  constexpr double kDepth = 0.3, kTau = 0.02, kInlierRatio = 0.6;
  DensePosterior dense(0, 1, 500, 100);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal(kDepth, kTau);
  for (int i = 0; i < 400; ++i) {
    dense.Update(uniform(random) < kInlierRatio ? normal(random) : uniform(random), kTau * kTau, 1);
  }
  // Standard errors: 0.02 / sqrt(240) = 0.0013 and sqrt(0.24 / 400) = 0.025.
  EXPECT_NEAR(dense.ModeOfZ(), kDepth, 0.005);
  EXPECT_NEAR(dense.Moments().mean_z, kDepth, 0.005);
  EXPECT_NEAR(dense.Moments().mean_pi, kInlierRatio, 0.08);
}

TEST(DensePosteriorTest, RefusesAnEmptyGrid) {
  EXPECT_THROW(DensePosterior(1, 1, 10, 10), std::invalid_argument);
  EXPECT_THROW(DensePosterior(0, 1, 0, 10), std::invalid_argument);
}

// The three ways to Eq. (4) must agree: the histogram knows nothing of moments, the textbook form
// nothing of core's algebra, and core's works in float, too.
class FuseOracleTest : public ::testing::Test {
 protected:
  struct Case {
    Posterior<double> q;
    double x, tau2, u;
  };

  Case Next() {
    const auto log_uniform = [this](double low, double high) {
      std::uniform_real_distribution<double> d(std::log(low), std::log(high));
      return std::exp(d(random_));
    };
    Case c{};
    c.q.mu = std::uniform_real_distribution<double>(0, 1)(random_);
    const double sigma = log_uniform(1e-3, 0.2);
    const double tau = std::clamp(log_uniform(1e-3, 0.3), sigma / 30, 1.0);
    c.q.sigma2 = sigma * sigma;
    c.tau2 = tau * tau;
    c.q.a = log_uniform(3, 200);
    c.q.b = log_uniform(3, 200);
    c.u = log_uniform(0.5, 100);
    const double innovation = std::uniform_real_distribution<double>(-6, 6)(random_);
    c.x = c.q.mu + innovation * std::sqrt(c.q.sigma2 + c.tau2);
    return c;
  }

  std::mt19937 random_{7};
};

TEST_F(FuseOracleTest, ClosedFormMatchesTheDenseHistogram) {
  // Rectangle rule: spectrally exact in Z, where the step is half the narrower standard deviation;
  // O(bins^-2) in pi, where the densities vanish at both ends.
  constexpr int kPiBins = 2000;
  constexpr double kTolerance = 2e-5;
  for (int n = 0; n < 300; ++n) {
    const Case c = Next();
    const double s = std::sqrt(c.q.sigma2 * c.tau2 / (c.q.sigma2 + c.tau2));
    const double sigma = std::sqrt(c.q.sigma2);
    const double reach = 9 * sigma;
    const int bins = static_cast<int>(std::ceil(2 * reach / (0.5 * s)));
    DensePosterior dense(c.q.mu - reach, c.q.mu + reach, bins, kPiBins);
    dense.SetPrior(c.q);
    dense.Update(c.x, c.tau2, c.u);
    const Posterior<double> expected = MatchMoments(dense.Moments());
    const Posterior<double> fused = Fuse(c.q, c.x, c.tau2, c.u).posterior;
    ASSERT_NEAR(fused.mu, expected.mu, kTolerance * std::sqrt(expected.sigma2)) << n;
    ASSERT_NEAR(fused.sigma2, expected.sigma2, kTolerance * expected.sigma2) << n;
    ASSERT_NEAR(fused.a, expected.a, kTolerance * expected.a) << n;
    ASSERT_NEAR(fused.b, expected.b, kTolerance * expected.b) << n;
  }
}

TEST_F(FuseOracleTest, ClosedFormMatchesTheTextbook) {
  // What the textbook form loses by cancellation in double for these states (a, b of 200,
  // sigma of 1e-3 at mu of 1).
  constexpr double kBetaTolerance = 1e-9, kVarianceTolerance = 1e-6, kMeanTolerance = 1e-9;
  for (int n = 0; n < 20'000; ++n) {
    const Case c = Next();
    const Posterior<double> expected = FuseTextbook(c.q, c.x, c.tau2, c.u);
    const Posterior<double> fused = Fuse(c.q, c.x, c.tau2, c.u).posterior;
    ASSERT_NEAR(fused.mu, expected.mu, kMeanTolerance) << n;
    ASSERT_NEAR(fused.sigma2, expected.sigma2, kVarianceTolerance * expected.sigma2) << n;
    ASSERT_NEAR(fused.a, expected.a, kBetaTolerance * expected.a) << n;
    ASSERT_NEAR(fused.b, expected.b, kBetaTolerance * expected.b) << n;
  }
}

TEST_F(FuseOracleTest, FloatMatchesDouble) {
  // A few roundings; the weight's exponent of up to 18 amplifies that of d² / 2v, and d inherits
  // the ulp of mu and x (6e-8) over a sigma of 1e-3.
  constexpr double kTolerance = 2e-3;
  constexpr double kTypical = 2e-6;
  double sum = 0;
  constexpr int kCases = 20'000;
  for (int n = 0; n < kCases; ++n) {
    const Case c = Next();
    const Posterior<float> q = {static_cast<float>(c.q.mu),
                                static_cast<float>(c.q.sigma2),
                                static_cast<float>(c.q.a),
                                static_cast<float>(c.q.b)};
    const auto x = static_cast<float>(c.x), tau2 = static_cast<float>(c.tau2);
    const auto u = static_cast<float>(c.u);
    const Posterior<float> fused = Fuse(q, x, tau2, u).posterior;
    // The same rounded inputs in double: only the arithmetic differs.
    const Posterior<double> expected =
        Fuse<double>({q.mu, q.sigma2, q.a, q.b}, x, tau2, u).posterior;
    ASSERT_NEAR(fused.mu, expected.mu, kTolerance * std::sqrt(expected.sigma2)) << n;
    ASSERT_NEAR(fused.sigma2, expected.sigma2, kTolerance * expected.sigma2) << n;
    ASSERT_NEAR(fused.a, expected.a, kTolerance * expected.a) << n;
    ASSERT_NEAR(fused.b, expected.b, kTolerance * expected.b) << n;
    sum += std::abs(fused.sigma2 / expected.sigma2 - 1);
  }
  EXPECT_LT(sum / kCases, kTypical);
}

TEST_F(FuseOracleTest, TextbookInFloatAgreesFarFromConvergence) {
  // Wide states lose few digits: a float's 6e-8 times 1 / sigma² of at most 400, and a few
  // roundings.
  constexpr double kTolerance = 3e-4;
  for (int n = 0; n < 2000; ++n) {
    const Case c = Next();
    if (c.q.sigma2 < 0.05 * 0.05 || c.tau2 < 0.05 * 0.05 || c.q.a > 20 || c.q.b > 20) continue;
    const Posterior<float> q = {static_cast<float>(c.q.mu),
                                static_cast<float>(c.q.sigma2),
                                static_cast<float>(c.q.a),
                                static_cast<float>(c.q.b)};
    const auto x = static_cast<float>(c.x), tau2 = static_cast<float>(c.tau2);
    const auto u = static_cast<float>(c.u);
    const Posterior<float> textbook = FuseTextbook(q, x, tau2, u);
    const Posterior<double> expected =
        Fuse<double>({q.mu, q.sigma2, q.a, q.b}, x, tau2, u).posterior;
    ASSERT_NEAR(textbook.mu, expected.mu, kTolerance) << n;
    ASSERT_NEAR(textbook.sigma2, expected.sigma2, 10 * kTolerance * expected.sigma2) << n;
    ASSERT_NEAR(textbook.a, expected.a, 10 * kTolerance * expected.a) << n;
  }
}

TEST_F(FuseOracleTest, TextbookInFloatLosesTheVarianceNearConvergence) {
  // sigma = 1e-4 at mu of 1: E[Z²] - E[Z]² is less than a float's last digit. Half of the results
  // are not even positive; the closed form's all are.
  int not_positive = 0;
  constexpr int kCases = 2000;
  std::uniform_real_distribution<float> offset(-1, 1);
  for (int n = 0; n < kCases; ++n) {
    const Posterior<float> q = {1 + 0.3F * offset(random_), 1e-8F, 20, 10};
    const float x = q.mu + 1e-4F * offset(random_), tau2 = 1e-6F;
    if (!(FuseTextbook(q, x, tau2, 1.0F).sigma2 > 0)) ++not_positive;
    ASSERT_GT(Fuse(q, x, tau2, 1.0F).posterior.sigma2, 0) << n;
  }
  EXPECT_GT(not_positive, kCases / 4);
}

TEST_F(FuseOracleTest, ManyMeasurementsFollowTheHistogram) {
  // [VH11] Fig. 3, rows 1 and 2: the approximation converges to the same estimate.
  constexpr double kDepth = 0.42, kTau = 0.02;
  const Posterior<double> prior = {0.5, 0.19 * 0.19, 10, 10};
  DensePosterior dense(-0.5, 1.5, 1000, 200);
  dense.SetPrior(prior);
  Posterior<double> q = prior;
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal(kDepth, kTau);
  for (int i = 0; i < 100; ++i) {
    const double x = uniform(random_) < 0.7 ? normal(random_) : uniform(random_);
    dense.Update(x, kTau * kTau, 1);
    q = Fuse(q, x, kTau * kTau, 1.0).posterior;
  }
  const PosteriorMoments m = dense.Moments();
  EXPECT_NEAR(q.mu, m.mean_z, 2 * std::sqrt(m.var_z));
  EXPECT_NEAR(q.sigma2 / m.var_z, 1, 0.3);
  EXPECT_NEAR(InlierRatio(q), m.mean_pi, 0.05);
}

}  // namespace
}  // namespace livemvs::reference
