#include "livemvs/map/finish_cloud.h"

#include <gtest/gtest.h>

namespace livemvs {
namespace {

constexpr float kSpacing = 0.01F;
constexpr int kSide = 20;

// A flat sheet at z = 0 from (0, 0), a point a footprint.
PointCloud Sheet() {
  PointCloud cloud;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      Point p;
      p.position = {kSpacing * static_cast<float>(x), kSpacing * static_cast<float>(y), 0};
      p.normal = {0, 0, 1};
      p.sigma = 0.5F * kSpacing;
      p.footprint = kSpacing;
      cloud.push_back(p);
    }
  }
  return cloud;
}

// The left two columns of the sheet.
const Box kNarrow{{-0.5 * kSpacing, -1, -1}, {1.5 * kSpacing, 1, 1}};

TEST(FinishCloudTest, LeavesOutWhatLiesOutsideOfTheBox) {
  PointCloud cloud = Sheet();
  const FinishedCloud finished = FinishCloud({}, kNarrow, &cloud);
  EXPECT_EQ(cloud.size() + finished.unsupported + finished.outside, kSide * kSide);
  EXPECT_GT(finished.outside, kSide * (kSide - 3));
  for (const Point& p : cloud) EXPECT_LT(p.position.x(), 1.5F * kSpacing);
}

TEST(FinishCloudTest, KeepsAllWithoutABox) {
  PointCloud cloud = Sheet();
  const FinishedCloud finished = FinishCloud({}, std::nullopt, &cloud);
  EXPECT_EQ(finished.outside, 0);
  EXPECT_EQ(cloud.size() + finished.unsupported, kSide * kSide);
}

TEST(FinishCloudTest, NeighboursBeyondTheBoxCount) {
  // Three points, which are too few to support each other.
  const Box tiny{{-0.5 * kSpacing, -0.5 * kSpacing, -1}, {0.5 * kSpacing, 2.5 * kSpacing, 1}};
  PointCloud whole = Sheet();
  FinishCloud({}, tiny, &whole);
  EXPECT_EQ(whole.size(), 3);
  PointCloud cut = Sheet();
  std::erase_if(cut, [&](const Point& p) { return !tiny.Contains(p.position.cast<double>()); });
  ASSERT_EQ(cut.size(), 3);
  FinishCloud({}, tiny, &cut);
  EXPECT_EQ(cut.size(), 0);
}

TEST(FinishCloudTest, FinerPointsBeyondTheBoxDoNotReplaceThoseWithin) {
  Options options;
  options.levels = 3;
  options.regularise_px = 0;
  options.min_support = 0;
  Point coarse, fine;
  coarse.position = {-0.001F, 0, 0};
  coarse.footprint = 0.02F;
  fine.position = {0.005F, 0, 0};
  fine.footprint = 0.005F;
  PointCloud cloud = {coarse, fine};
  const FinishedCloud finished = FinishCloud(options, Box{{-1, -1, -1}, {0, 1, 1}}, &cloud);
  EXPECT_EQ(finished.superseded, 0);
  EXPECT_EQ(finished.outside, 1);
  ASSERT_EQ(cloud.size(), 1);
  EXPECT_EQ(cloud[0].footprint, coarse.footprint);
  // Without a box the finer one stands for it.
  cloud = {coarse, fine};
  EXPECT_EQ(FinishCloud(options, std::nullopt, &cloud).superseded, 1);
}

}  // namespace
}  // namespace livemvs
