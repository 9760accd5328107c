#include "livemvs/core/seed.h"

#include <gtest/gtest.h>

namespace livemvs {
namespace {

class JudgeTest : public ::testing::Test {
 protected:
  JudgeTest() {
    options_.coordinate = DepthCoordinate::kDepth;
    options_.eta_inlier = 0.5F;
    options_.eta_outlier = 0.05F;
    options_.outlier_certainty = 0.99F;
    options_.epsilon_range = 0.01F;
    options_.epsilon_px = 0;
    options_.min_views = 3;
    options_.max_age = 100;
    options_.max_unseen = 10;
  }

  Fate Judged(const Posterior<float>& q,
              const SeedCounts& counts,
              float pixel_width = 1e-3F) const {
    const OutlierRule rule(options_.eta_outlier, options_.outlier_certainty);
    return Judge(options_, rule, interval_, q, counts, q.sigma2, pixel_width);
  }

  Options options_;
  Interval<float> interval_ = {2, 4};
};

constexpr SeedCounts kSeen = {20, 20, 0};

TEST_F(JudgeTest, ConvergesBySigmaAsAShareOfTheRange) {
  EXPECT_EQ(Judged({0.5F, 0.0099F * 0.0099F, 20, 10}, kSeen), Fate::kConverged);
  EXPECT_EQ(Judged({0.5F, 0.0101F * 0.0101F, 20, 10}, kSeen), Fate::kAlive);
}

TEST_F(JudgeTest, ConvergesBySigmaInPixels) {
  options_.epsilon_range = 0;
  options_.epsilon_px = 0.5F;
  // Depth 3, a pixel is 3e-3 wide there, half of it is 1.5e-3, over the interval's 2: 7.5e-4.
  EXPECT_EQ(Judged({0.5F, 7.4e-4F * 7.4e-4F, 20, 10}, kSeen), Fate::kConverged);
  EXPECT_EQ(Judged({0.5F, 7.6e-4F * 7.6e-4F, 20, 10}, kSeen), Fate::kAlive);
}

TEST_F(JudgeTest, InlierRatioAndViewsAreNeeded) {
  EXPECT_EQ(Judged({0.5F, 1e-6F, 10, 10.1F}, kSeen), Fate::kAlive);
  EXPECT_EQ(Judged({0.5F, 1e-6F, 20, 10}, {20, 2, 0}), Fate::kAlive);
  EXPECT_EQ(Judged({0.5F, 1e-6F, 20, 10}, {20, 3, 0}), Fate::kConverged);
}

TEST_F(JudgeTest, PrunesBadOldLostAndWanderingSeeds) {
  EXPECT_EQ(Judged({0.5F, 0.03F, 10, 400}, kSeen), Fate::kOutlier);
  EXPECT_EQ(Judged({0.5F, 0.03F, 10, 10}, {100, 0, 0}), Fate::kAged);
  EXPECT_EQ(Judged({0.5F, 0.03F, 10, 10}, {99, 0, 0}), Fate::kAlive);
  EXPECT_EQ(Judged({0.5F, 0.03F, 10, 10}, {5, 0, 10}), Fate::kUnseen);
  EXPECT_EQ(Judged({1.2F, 0.03F, 10, 10}, kSeen), Fate::kLeftInterval);
  EXPECT_EQ(Judged({-0.2F, 0.03F, 10, 10}, kSeen), Fate::kLeftInterval);
  EXPECT_EQ(Judged({std::nanf(""), 0.03F, 10, 10}, kSeen), Fate::kLeftInterval);
  EXPECT_EQ(Judged({1.05F, 1e-6F, 20, 10}, kSeen), Fate::kLeftInterval)
      << "converged, but where no points are wanted";
  options_.max_age = 0;
  options_.max_unseen = 0;
  EXPECT_EQ(Judged({0.5F, 0.03F, 10, 10}, {60'000, 0, 255}), Fate::kAlive);
}

TEST_F(JudgeTest, DoesNotDependOnTheUnit) {
  const Posterior<float> q = {0.3F, 0.0095F * 0.0095F, 20, 10};
  for (const float unit : {1e-3F, 1.0F, 1e3F}) {
    interval_ = {2 * unit, 4 * unit};
    EXPECT_EQ(Judged(q, kSeen), Fate::kConverged);
  }
}

TEST_F(JudgeTest, SharedErrorOfTheMatchesDelaysConversion) {
  const OutlierRule rule(options_.eta_outlier, options_.outlier_certainty);
  const Posterior<float> q = {0.5F, 0.006F * 0.006F, 20, 10};
  const auto judged = [&](float total) {
    return Judge(options_, rule, interval_, q, kSeen, total, 1e-3F);
  };
  constexpr float kBias2 = 0.2F * 0.2F;  // [px²]
  // The threshold is 0.01; a pixel is worth 0.05 of mu at a short baseline, 0.02 at a longer one.
  EXPECT_FLOAT_EQ(TotalVariance(q.sigma2, kBias2, 0.05F), 0.006F * 0.006F + 0.01F * 0.01F);
  EXPECT_EQ(judged(TotalVariance(q.sigma2, kBias2, 0.05F)), Fate::kAlive);
  EXPECT_EQ(judged(TotalVariance(q.sigma2, kBias2, 0.02F)), Fate::kConverged);
  EXPECT_EQ(judged(-1), Fate::kAlive) << "a frame without a match converts nothing";
}

TEST(DepthOfTest, InverseDepthMatchesTheNumericDerivative) {
  const Interval<double> interval = {1 / 2.0, 1 / 8.0};
  constexpr double kStep = 1e-6, kSigma = 1e-3, kMu = 0.4;
  const auto at = [&](double mu) {
    return DepthOf(DepthCoordinate::kInverseDepth, interval, mu, kSigma * kSigma);
  };
  EXPECT_NEAR(at(0).depth, 2, 1e-12);
  EXPECT_NEAR(at(1).depth, 8, 1e-12);
  const double rate = (at(kMu + kStep).depth - at(kMu - kStep).depth) / (2 * kStep);
  EXPECT_NEAR(at(kMu).sigma, rate * kSigma, 1e-8);
}

TEST(DepthRangeTest, IsTheSameInBothCoordinates) {
  EXPECT_NEAR(DepthRange<double>(DepthCoordinate::kDepth, {2, 8}), 6, 1e-12);
  EXPECT_NEAR(DepthRange<double>(DepthCoordinate::kInverseDepth, {0.5, 0.125}), 6, 1e-12);
}

}  // namespace
}  // namespace livemvs
