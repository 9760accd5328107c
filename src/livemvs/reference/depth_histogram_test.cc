#include "livemvs/reference/depth_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace livemvs::reference {
namespace {

TEST(DepthHistogramTest, CountsVotesInTheirBins) {
  DepthHistogram histogram(10, 20, 5);
  for (const double depth : {9.99, 10.0, 11.99, 12.0, 15.0, 20.0, 20.01}) histogram.Vote(depth);
  EXPECT_EQ(histogram.votes(0), 2);  // 10.0, 11.99
  EXPECT_EQ(histogram.votes(1), 1);
  EXPECT_EQ(histogram.votes(2), 1);
  EXPECT_EQ(histogram.votes(3), 0);
  EXPECT_EQ(histogram.votes(4), 1);  // 20.0; 20.01 is outside
  ASSERT_TRUE(histogram.Mode().has_value());
  EXPECT_DOUBLE_EQ(*histogram.Mode(), 11);
}

TEST(DepthHistogramTest, FullestBinHoldsTheDensestStretch) {
  // Against counting in the sorted list, without bins.
  constexpr double kTrue = 3.217;
  std::mt19937 random(3);
  std::normal_distribution<double> good(kTrue, 0.01);
  std::uniform_real_distribution<double> bad(2, 5);
  DepthHistogram histogram(2, 5, 60);
  std::vector<double> votes;
  for (int i = 0; i < 400; ++i) {
    votes.push_back(i % 4 == 0 ? good(random) : bad(random));
    histogram.Vote(votes.back());
  }
  int fullest = 0;
  for (int i = 0; i < 60; ++i) {
    const double low = 2 + i * 0.05;
    const auto inside = [low](double v) { return v >= low && v < low + 0.05; };
    const int count = static_cast<int>(std::count_if(votes.begin(), votes.end(), inside));
    EXPECT_EQ(histogram.votes(i), count) << i;
    fullest = std::max(fullest, count);
  }
  const double mode = histogram.Mode().value();
  EXPECT_EQ(
      std::count_if(
          votes.begin(), votes.end(), [mode](double v) { return std::abs(v - mode) <= 0.025; }),
      fullest);
  EXPECT_NEAR(mode, kTrue, 0.025);  // half a bin
}

TEST(DepthHistogramTest, HasNoAnswerWithoutVotes) {
  DepthHistogram histogram(0, 1, 10);
  histogram.Vote(2);
  EXPECT_FALSE(histogram.Mode().has_value());
}

TEST(DepthHistogramTest, RefusesAnEmptyRange) {
  EXPECT_THROW(DepthHistogram(1, 1, 10), std::invalid_argument);
  EXPECT_THROW(DepthHistogram(0, 1, 0), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs::reference
