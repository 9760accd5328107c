#include "livemvs/core/posterior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace livemvs {
namespace {

TEST(ExpTest, IsAccurateOverItsRange) {
  constexpr double kTolerance = 3e-7;  // as documented
  for (int i = 0; i <= 870'000; ++i) {
    const float x = static_cast<float>(i) * 1e-4F;
    const double expected = std::exp(static_cast<double>(x));
    ASSERT_NEAR(Exp(x) / expected, 1, kTolerance) << x;
  }
  EXPECT_EQ(Exp(0.0F), 1.0F);
}

TEST(FuseTest, CertainlyGoodMeasurementCountsAsOneInlier) {
  // u -> 0: w1 = 1.
  const auto fused = Fuse<double>({0.5, 0.01, 10, 7}, 0.55, 0.0025, 1e-300);
  EXPECT_DOUBLE_EQ(fused.inlier_weight, 1);
  EXPECT_DOUBLE_EQ(fused.posterior.a, 11);
  EXPECT_DOUBLE_EQ(fused.posterior.b, 7);
  // The product of two Gaussians.
  EXPECT_DOUBLE_EQ(fused.posterior.sigma2, 1 / (1 / 0.01 + 1 / 0.0025));
  EXPECT_DOUBLE_EQ(fused.posterior.mu, (0.5 / 0.01 + 0.55 / 0.0025) * fused.posterior.sigma2);
}

TEST(FuseTest, CertainOutlierCountsAsAMiss) {
  const Posterior<float> q = {0.1F, 1e-6F, 10, 7};
  const auto fused = Fuse(q, 0.9F, 1e-6F, 100.0F);
  const Posterior<float> miss = Miss(q);
  EXPECT_LT(fused.inlier_weight, 1e-20F);
  EXPECT_FLOAT_EQ(fused.posterior.a, miss.a);
  EXPECT_FLOAT_EQ(fused.posterior.b, miss.b);
  EXPECT_EQ(fused.posterior.mu, q.mu);
  EXPECT_FLOAT_EQ(fused.posterior.sigma2, q.sigma2);
}

TEST(FuseTest, StaysPositiveAndFiniteForExtremeStates) {
  // Far beyond what a reconstruction meets: the form in which variances cancel fails here in more
  // than a third of the cases.
  std::mt19937 random(3);
  const auto log_uniform = [&](float low, float high) {
    std::uniform_real_distribution<float> d(std::log(low), std::log(high));
    return std::exp(d(random));
  };
  std::normal_distribution<float> normal;
  for (int n = 0; n < 100'000; ++n) {
    const float sigma = log_uniform(1e-6F, 1), tau = log_uniform(1e-6F, 1);
    const Posterior<float> q = {
        log_uniform(1e-2F, 100), sigma * sigma, log_uniform(0.5F, 1e5F), log_uniform(0.5F, 1e5F)};
    const float x = q.mu + 8 * normal(random) * std::sqrt(sigma * sigma + tau * tau);
    const auto fused = Fuse(q, x, tau * tau, log_uniform(1e-3F, 1e6F));
    const Posterior<float>& p = fused.posterior;
    ASSERT_TRUE(p.sigma2 > 0 && std::isfinite(p.sigma2)) << n;
    ASSERT_TRUE(p.a > 0 && p.b > 0 && std::isfinite(p.a) && std::isfinite(p.b)) << n;
    ASSERT_TRUE(std::isfinite(p.mu)) << n;
    ASSERT_TRUE(fused.inlier_weight >= 0 && fused.inlier_weight <= 1) << n;
    // The evidence never grows by more than the one measurement; the mean stays between the two.
    ASSERT_LE(p.a + p.b, (q.a + q.b + 1) * 1.00001F) << n;
    const float ulps = 1e-6F * (std::abs(q.mu) + std::abs(x));
    ASSERT_GE(p.mu, std::min(q.mu, x) - ulps) << n;
    ASSERT_LE(p.mu, std::max(q.mu, x) + ulps) << n;
  }
}

TEST(FuseTest, StaysPositiveOverALongSequence) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::normal_distribution<float> normal(0.37F, 1e-3F);
  Posterior<float> q = {0.5F, 0.04F, 10, 10};
  for (int n = 0; n < 100'000; ++n) {
    q = Fuse(q, uniform(random) < 0.8F ? normal(random) : uniform(random), 1e-6F, 1.0F).posterior;
    ASSERT_TRUE(q.sigma2 > 0 && q.a > 0 && q.b > 0) << n;
    ASSERT_TRUE(std::isfinite(q.sigma2 + q.a + q.b + q.mu)) << n;
  }
  EXPECT_NEAR(q.mu, 0.37, 1e-4);
  EXPECT_NEAR(InlierRatio(q), 0.8, 0.03);
}

double BetaCdfByQuadrature(double x, double a, double b) {
  // Midpoint rule in t, where pi = t³ (10 - 15 t + 6 t²) flattens both ends.
  const auto integral = [&](double end) {
    constexpr int kSteps = 20'000;
    double low = 0, high = 1;
    for (int i = 0; i < 80; ++i) {
      const double t = (low + high) / 2;
      (t * t * t * (10 - 15 * t + 6 * t * t) < end ? low : high) = t;
    }
    const double t_end = end >= 1 ? 1 : low;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = (i + 0.5) * t_end / kSteps;
      const double pi = t * t * t * (10 - 15 * t + 6 * t * t);
      const double d = 30 * t * t * (1 - t) * (1 - t);
      sum += std::pow(pi, a - 1) * std::pow(1 - pi, b - 1) * d;
    }
    return sum * t_end / kSteps;
  };
  return integral(x) / integral(1);
}

TEST(BetaCdfTest, KnownValues) {
  EXPECT_NEAR(BetaCdf(0.3, 1, 1), 0.3, 1e-12);
  EXPECT_NEAR(BetaCdf(0.3, 2, 1), 0.09, 1e-12);
  EXPECT_NEAR(BetaCdf(0.3, 1, 3), 1 - 0.7 * 0.7 * 0.7, 1e-12);
  EXPECT_NEAR(BetaCdf(0.5, 17.5, 17.5), 0.5, 1e-12);
  // Binomial tail: P(X >= 3) of 5 at 0.4.
  EXPECT_NEAR(BetaCdf(0.4, 3, 3), 0.31744, 1e-10);
  EXPECT_EQ(BetaCdf(0, 2, 3), 0);
  EXPECT_EQ(BetaCdf(1, 2, 3), 1);
  EXPECT_EQ(BetaCdf(-1, 2, 3), 0);
  EXPECT_EQ(BetaCdf(2, 2, 3), 1);
}

TEST(BetaCdfTest, MatchesQuadrature) {
  for (const double a : {0.7, 2.0, 10.0, 55.0}) {
    for (const double b : {0.9, 4.0, 30.0, 362.0}) {
      for (const double x : {0.01, 0.05, 0.3, 0.7, 0.95}) {
        EXPECT_NEAR(BetaCdf(x, a, b), BetaCdfByQuadrature(x, a, b), 1e-6)
            << x << ' ' << a << ' ' << b;
      }
    }
  }
}

TEST(BetaCdfTest, IsSymmetricAndStableForLargeCounts) {
  for (const double a : {1e3, 2e4, 9e4}) {
    const double x = a / (2 * a + 50) + 1e-3;
    EXPECT_NEAR(BetaCdf(x, a, a + 50), 1 - BetaCdf(1 - x, a + 50, a), 1e-9);
    EXPECT_GT(BetaCdf(x, a, a + 50), 0.5);
  }
}

TEST(OutlierRuleTest, AgreesWithTheIncompleteBetaFunction) {
  // The table interpolates b linearly in a: what it decides differently lies within this of the
  // true threshold.
  constexpr double kRelative = 0.003;
  const OutlierRule rule(0.05, 0.99);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw_a(0.5, 63), draw_factor(0, 2);
  int outliers = 0;
  for (int n = 0; n < 5000; ++n) {
    const double a = draw_a(random);
    const double b = draw_factor(random) * 35 * (a + 1);
    const bool expected = BetaCdf(0.05, a, b) > 0.99;
    const bool at_less = BetaCdf(0.05, a, b * (1 - kRelative)) > 0.99;
    const bool at_more = BetaCdf(0.05, a, b * (1 + kRelative)) > 0.99;
    if (at_less != at_more) continue;
    EXPECT_EQ(rule(static_cast<float>(a), static_cast<float>(b)), expected) << a << ' ' << b;
    outliers += expected;
  }
  EXPECT_GT(outliers, 1000);
  EXPECT_LT(outliers, 4500);
}

TEST(OutlierRuleTest, ThePapersRuleTakes352FailuresFromThePrior) {
  const OutlierRule rule(0.05, 0.99);
  int failures = 0;
  float b = 10;
  while (!rule(10.0F, b)) {
    b += 1;
    ++failures;
  }
  EXPECT_EQ(failures, 352);
}

TEST(OutlierRuleTest, NeverCondemnsAtZeroOrWithMuchSupport) {
  EXPECT_FALSE(OutlierRule(0, 0.99)(1.0F, 1e6F));
  EXPECT_FALSE(OutlierRule(0.05, 0.99)(1e4F, 1e4F));
  EXPECT_FALSE(OutlierRule(0.05, 0.99)(std::nanf(""), 10.0F));
}

}  // namespace
}  // namespace livemvs
