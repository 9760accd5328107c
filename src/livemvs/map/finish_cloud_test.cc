#include "livemvs/map/finish_cloud.h"

#include <gtest/gtest.h>

#include "livemvs/core/lean.h"

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

// Of the sheet only its inner points would stay, which is not what most tests are about.
Options WithRims() {
  Options options;
  options.rim_px = 0;
  return options;
}

// The left two columns of the sheet.
const Box kNarrow{{-0.5 * kSpacing, -1, -1}, {1.5 * kSpacing, 1, 1}};

TEST(FinishCloudTest, LeavesOutWhatLiesOutsideOfTheBox) {
  PointCloud cloud = Sheet();
  const FinishedCloud finished = FinishCloud(WithRims(), kNarrow, &cloud);
  EXPECT_EQ(cloud.size() + finished.unsupported + finished.outside, kSide * kSide);
  EXPECT_GT(finished.outside, kSide * (kSide - 3));
  for (const Point& p : cloud) EXPECT_LT(p.position.x(), 1.5F * kSpacing);
}

TEST(FinishCloudTest, KeepsAllWithoutABox) {
  PointCloud cloud = Sheet();
  const FinishedCloud finished = FinishCloud(WithRims(), std::nullopt, &cloud);
  EXPECT_EQ(finished.outside, 0);
  EXPECT_EQ(cloud.size() + finished.unsupported, kSide * kSide);
}

TEST(FinishCloudTest, NeighboursBeyondTheBoxCount) {
  // Three points, which are too few to support each other.
  const Box tiny{{-0.5 * kSpacing, -0.5 * kSpacing, -1}, {0.5 * kSpacing, 2.5 * kSpacing, 1}};
  PointCloud whole = Sheet();
  FinishCloud(WithRims(), tiny, &whole);
  EXPECT_EQ(whole.size(), 3);
  PointCloud cut = Sheet();
  std::erase_if(cut, [&](const Point& p) { return !tiny.Contains(p.position.cast<double>()); });
  ASSERT_EQ(cut.size(), 3);
  FinishCloud(WithRims(), tiny, &cut);
  EXPECT_EQ(cut.size(), 0);
}

TEST(FinishCloudTest, TakesOffRimsOfSurfacesButNotThoseOfTheBox) {
  // What the row next to the outermost has around it lies within a footprint.
  Options options;
  options.rim_px = 1.5F;
  const Box left{{-1, -1, -1}, {5.5 * kSpacing, 1, 1}};
  PointCloud cloud = Sheet();
  const FinishedCloud finished = FinishCloud(options, left, &cloud);
  EXPECT_EQ(finished.rims + finished.unsupported, 4 * (kSide - 1));
  EXPECT_EQ(finished.outside, (kSide - 2) * (kSide - 7));
  ASSERT_EQ(cloud.size(), (kSide - 2) * 5);
  for (const Point& p : cloud) EXPECT_GT(p.position.x(), 0.5F * kSpacing);
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

TEST(FinishCloudTest, SaysWhichPointsItKept) {
  PointCloud cloud = Sheet();
  const PointCloud before = cloud;
  Point alone = cloud.front();
  alone.position = {-1, 0, 0};
  cloud.insert(cloud.begin(), alone);
  Point overhanging = cloud.back();
  overhanging.lean = LeanCode(overhanging.normal, {-1, 0, 0});  // ahead of it lies nothing
  cloud.push_back(overhanging);
  cloud.push_back(before.back());
  const FinishedCloud finished = FinishCloud(WithRims(), std::nullopt, &cloud);
  EXPECT_EQ(finished.unsupported, 1);
  EXPECT_EQ(finished.overhanging, 1);
  ASSERT_EQ(finished.kept.size(), cloud.size());
  ASSERT_EQ(cloud.size(), before.size() + 1);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(finished.kept[i], i + 1);
  EXPECT_EQ(finished.kept.back(), before.size() + 2);
}

TEST(FinishCloudTest, CoarsePointsHoldOthersBeforeFinerOnesReplaceThem) {
  PointCloud cloud = Sheet();
  for (Point& p : cloud) p.lean = kLeanUnknown;
  const std::size_t last = cloud.size();
  Point leaning = cloud.front();
  leaning.lean = LeanCode(leaning.normal, {-1, 0, 0});
  cloud.push_back(leaning);
  for (int i = 3; i < 6; ++i) {
    Point coarse = cloud[i];
    coarse.level = 1;
    coarse.footprint *= 2;
    coarse.lean = kLeanNowhere;
    cloud.push_back(coarse);
  }
  const Box left{{-1, -1, -1}, {5.5 * kSpacing, 1, 1}};
  const FinishedCloud finished = FinishCloud(WithRims(), left, &cloud);
  EXPECT_EQ(finished.overhanging, 0);
  EXPECT_EQ(finished.superseded, 3);
  // Of the sheet, the left six columns; and the leaning one.
  ASSERT_EQ(cloud.size(), 6 * kSide + 1 - finished.unsupported);
  ASSERT_EQ(finished.kept.size(), cloud.size());
  EXPECT_EQ(finished.kept.back(), last);
  for (std::size_t i = 0; i + 1 < cloud.size(); ++i) EXPECT_LT(finished.kept[i] % kSide, 6U);
}

}  // namespace
}  // namespace livemvs
