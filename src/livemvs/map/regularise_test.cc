#include "livemvs/map/regularise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "livemvs/map/remove_marked.h"
#include "livemvs/map/supersede.h"

namespace livemvs {
namespace {

constexpr float kSheetPixel = 0.01F;
constexpr float kSheetSigma = 0.008F;

Point SheetPoint(float x, float y, float z) {
  Point p;
  p.position = {x, y, z};
  p.normal = {0, 0, 1};
  p.sigma = kSheetSigma;
  p.footprint = kSheetPixel;
  return p;
}

// A sheet at z = 0, a point a footprint, with the noise that the points claim to have.
PointCloud NoisySheet() {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, kSheetSigma);
  PointCloud cloud;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      cloud.push_back(SheetPoint(
          kSheetPixel * static_cast<float>(x), kSheetPixel * static_cast<float>(y), noise(random)));
    }
  }
  return cloud;
}

std::size_t Count(const std::vector<char>& marks) {
  return static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1));
}

double RmsZ(const PointCloud& cloud) {
  double sum = 0;
  for (const Point& p : cloud) sum += static_cast<double>(p.position.z()) * p.position.z();
  return std::sqrt(sum / static_cast<double>(cloud.size()));
}

TEST(RegulariseTest, NoiseOnASurfaceAveragesOut) {
  PointCloud cloud = NoisySheet();
  const double before = RmsZ(cloud);
  EXPECT_LT(Count(Regularise({}, &cloud)), 40U);  // a Gaussian's tail may lose its support
  EXPECT_LT(RmsZ(cloud), 0.6 * before);
}

TEST(RegulariseTest, NoPointMovesFurtherThanItsOwnUncertainty) {
  const PointCloud before = NoisySheet();
  PointCloud after = before;
  ASSERT_EQ(Count(Regularise({.min_support = 0}, &after)), 0U);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_LE((after[i].position - before[i].position).norm(), kSheetSigma * 1.0001F);
  }
}

TEST(RegulariseTest, LonelyPointsGo) {
  PointCloud cloud = NoisySheet();
  for (Point& p : cloud) p.position.z() *= 0.1F;
  const std::size_t sheet = cloud.size();
  cloud.push_back(SheetPoint(0.2F, 0.2F, 0.3F));
  cloud.push_back(SheetPoint(0.21F, 0.2F, 0.3F));
  const std::vector<char> unsupported = Regularise({}, &cloud);
  EXPECT_EQ(Count(unsupported), 2U);
  EXPECT_EQ(RemoveMarked(unsupported, &cloud), 2U);
  EXPECT_EQ(cloud.size(), sheet);
  for (const Point& p : cloud) EXPECT_LT(std::abs(p.position.z()), kSheetSigma);
}

TEST(RegulariseTest, PointsBesideASurfaceDoNotBendIt) {
  PointCloud cloud = NoisySheet();
  for (Point& p : cloud) p.position.z() *= 0.1F;
  const PointCloud alone = cloud;
  cloud.push_back(SheetPoint(0.2F, 0.2F, 4 * kSheetPixel));
  ASSERT_EQ(Count(Regularise({.min_support = 0}, &cloud)), 0U);
  for (std::size_t i = 0; i < alone.size(); ++i) {
    EXPECT_LT(std::abs(cloud[i].position.z()), 0.4F * kSheetSigma);
  }
}

TEST(RegulariseTest, AnEdgeStaysSharp) {
  PointCloud cloud;  // two sheets that meet at a right angle along y
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 30; ++u) {
      const float a = kSheetPixel * (static_cast<float>(u) + 0.5F);
      const float b = kSheetPixel * static_cast<float>(v);
      cloud.push_back(SheetPoint(a, b, 0));
      cloud.push_back(SheetPoint(0, b, a));
    }
  }
  for (Point& p : cloud) p.sigma = 0.25F * kSheetPixel;
  const std::vector<char> unsupported = Regularise({}, &cloud);
  RemoveMarked(unsupported, &cloud);
  // Points next to the edge may use up their uncertainty; the rest stays on its sheet.
  int moved = 0;
  for (const Point& p : cloud) {
    const float off = std::min(std::abs(p.position.x()), std::abs(p.position.z()));
    EXPECT_LE(off, 0.25F * kSheetPixel * 1.0001F);
    moved += off > 0.02F * kSheetPixel;
  }
  EXPECT_LT(moved, static_cast<int>(cloud.size()) / 10);
}

TEST(RegulariseTest, PointsThatDoNotKnowTheirUncertaintyStayAsTheyAre) {
  PointCloud cloud(3);
  cloud[1].position.x() = std::numeric_limits<float>::quiet_NaN();
  cloud[2].sigma = std::numeric_limits<float>::infinity();
  EXPECT_EQ(Regularise({}, &cloud), std::vector<char>(3, 0));
  EXPECT_EQ(cloud[0].position, Eigen::Vector3f::Zero());
  PointCloud none;
  EXPECT_TRUE(Regularise({}, &none).empty());
}

TEST(RegulariseTest, RefusesOptionsThatMakeNoSense) {
  PointCloud cloud;
  EXPECT_THROW(static_cast<void>(Regularise({.radius_px = 0}, &cloud)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(Regularise({.neighbors = 3}, &cloud)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(Regularise({.min_support = 17}, &cloud)), std::invalid_argument);
}

TEST(FindSupersededTest, CoarsePointsGoWhereFinerOnesAre) {
  PointCloud cloud = NoisySheet();
  for (Point& p : cloud) p.position.z() = 0;
  const std::size_t fine = cloud.size();
  Point coarse = SheetPoint(0.1F, 0.1F, 0.001F);
  coarse.footprint = 2 * kSheetPixel;
  cloud.push_back(coarse);  // on the sheet
  coarse.position.x() = 0.5F;
  cloud.push_back(coarse);  // beside it
  Point alike = SheetPoint(0.105F, 0.105F, 0.001F);
  alike.footprint = 1.3F * kSheetPixel;  // another distance, the same level
  cloud.push_back(alike);
  std::vector<char> expected(cloud.size(), 0);
  expected[fine] = 1;
  EXPECT_EQ(FindSuperseded(std::nullopt, cloud), expected);
}

TEST(FindSupersededTest, EmptyAndNotFiniteCloudsAreNoTrouble) {
  PointCloud cloud;
  EXPECT_TRUE(FindSuperseded(std::nullopt, cloud).empty());
  cloud.resize(2);
  cloud[0].position.x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(FindSuperseded(std::nullopt, cloud), std::vector<char>(2, 0));
}

}  // namespace
}  // namespace livemvs
