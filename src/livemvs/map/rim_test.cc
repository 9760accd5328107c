#include "livemvs/map/rim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "livemvs/reference/rim.h"

namespace livemvs {
namespace {

constexpr float kRimPixel = 0.01F;
constexpr double kThird = 2 * std::numbers::pi / 3;

// Seen from +z.
Point FlatPoint(float x, float y, float z = 0) {
  Point p;
  p.position = {x, y, z};
  p.normal = {0, 0, 1};
  p.sigma = 0.1F * kRimPixel;
  p.footprint = kRimPixel;
  return p;
}

// Three points in nearly the same place, in this direction from the origin [degrees].
PointCloud Towards(float angle, float distance_px = 1) {
  const float turn = angle * std::numbers::pi_v<float> / 180;
  PointCloud cloud;
  for (const float far : {0.99F, 1.0F, 1.01F}) {
    const float distance = far * distance_px * kRimPixel;
    cloud.push_back(FlatPoint(distance * std::cos(turn), distance * std::sin(turn)));
  }
  return cloud;
}

void Add(const PointCloud& more, PointCloud* cloud) {
  cloud->insert(cloud->end(), more.begin(), more.end());
}

// A point in the middle, last, and three each around it at these angles [degrees].
PointCloud Around(std::initializer_list<float> angles, float distance_px = 1) {
  PointCloud cloud;
  for (const float angle : angles) Add(Towards(angle, distance_px), &cloud);
  cloud.push_back(FlatPoint(0, 0));
  return cloud;
}

bool LastIsRim(const PointCloud& cloud, float radius_px = 6) {
  return FindRims({.radius_px = radius_px}, cloud).back() != 0;
}

TEST(FindRims, APointWithOthersAllAroundIsNone) {
  EXPECT_FALSE(LastIsRim(Around({0, 119, 238, 300})));
  EXPECT_TRUE(LastIsRim(Around({0, 121, 242})));
  EXPECT_TRUE(LastIsRim(Around({0, 60, 120, 180})));
  // The gap may lie where the angles start again.
  EXPECT_TRUE(LastIsRim(Around({-60, -30, 0, 30, 60})));
}

TEST(FindRims, WhereTooFewAreNearAPointIsNone) {
  PointCloud cloud = Around({0, 10, 20}, 19);
  ASSERT_EQ(cloud.size(), 10);
  EXPECT_TRUE(LastIsRim(cloud, 5));
  // Nine others, but not eight within four times the radius.
  EXPECT_FALSE(LastIsRim(cloud, 4.5F));
  cloud.erase(cloud.begin(), cloud.begin() + 2);
  EXPECT_FALSE(LastIsRim(cloud, 5));
  EXPECT_EQ(FindRims({}, {FlatPoint(0, 0)}), std::vector<char>(1, 0));
}

TEST(FindRims, OfASheetTheOutermostRowGoes) {
  constexpr int kFlatSide = 12;
  PointCloud cloud;
  for (int i = 0; i < kFlatSide * kFlatSide; ++i) {
    cloud.push_back(FlatPoint(kRimPixel * static_cast<float>(i % kFlatSide),
                              kRimPixel * static_cast<float>(i / kFlatSide)));
  }
  // Neighbours reach to the next row: inside of a row they lie all around.
  const std::vector<char> rims = FindRims({.radius_px = 1.5F}, cloud);
  for (int i = 0; i < kFlatSide * kFlatSide; ++i) {
    const int x = i % kFlatSide, y = i / kFlatSide;
    const bool outermost = x == 0 || y == 0 || x == kFlatSide - 1 || y == kFlatSide - 1;
    EXPECT_EQ(rims[i] != 0, outermost) << x << ' ' << y;
  }
}

TEST(FindRims, WhatLiesFarBehindIsAnotherSurface) {
  PointCloud cloud = Around({0, 90, 180, 270});
  EXPECT_FALSE(LastIsRim(cloud));
  const auto move = [&](float z) {
    for (int i = 0; i < 3; ++i) cloud[i].position.z() = z;
  };
  move(-3 * kRimPixel);
  EXPECT_TRUE(LastIsRim(cloud));
  // A slope of up to two is a surface, though; and so is what both may be wrong by.
  move(-1.9F * kRimPixel);
  EXPECT_FALSE(LastIsRim(cloud));
  move(-3 * kRimPixel);
  for (int i = 0; i < 3; ++i) cloud[i].sigma = kRimPixel;
  EXPECT_FALSE(LastIsRim(cloud));
}

TEST(FindRims, WhereManyAreNearThoseFarAwayDoNotCount) {
  // Nine near it at one side, others further away all around.
  PointCloud cloud = Around({0, 119, 238, 300}, 20);
  cloud.pop_back();
  for (const float angle : {0.0F, 30.0F, 60.0F}) Add(Towards(angle), &cloud);
  cloud.push_back(FlatPoint(0, 0));
  EXPECT_TRUE(LastIsRim(cloud));
  EXPECT_FALSE(LastIsRim(cloud, 21));
  // With three near it, five of the others are among the nearest eight.
  PointCloud three = Towards(0);
  for (const float angle : {100.0F, 200.0F, 260.0F}) Add(Towards(angle, 20), &three);
  three.push_back(FlatPoint(0, 0));
  EXPECT_FALSE(LastIsRim(three));
}

TEST(FindRims, RadiusIsInPixelsOfTheFinestLevel) {
  PointCloud cloud = Around({0, 90, 180, 270}, 5);
  cloud.pop_back();
  for (const float angle : {0.0F, 15.0F, 30.0F}) Add(Towards(angle), &cloud);
  cloud.push_back(FlatPoint(0, 0));
  EXPECT_FALSE(LastIsRim(cloud, 6));
  // Its pixels are as wide, but of a level whose pixels are four of the finest.
  cloud.back().level = 2;
  EXPECT_TRUE(LastIsRim(cloud, 6));
  cloud.back().footprint = 4 * kRimPixel;
  EXPECT_FALSE(LastIsRim(cloud, 6));
}

TEST(FindRims, PointsInTheSamePlaceSayNothing) {
  // They are in no direction, not in that of angle 0.
  PointCloud cloud = Around({50, 150, 245});
  cloud.insert(cloud.begin(), 20, cloud.back());
  EXPECT_TRUE(LastIsRim(cloud));
}

// Points of three levels on two crossing sheets with borders.
PointCloud CrossingSheets(unsigned seed, int points) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  PointCloud cloud;
  for (int i = 0; i < points; ++i) {
    const float x = 8 * kRimPixel * unit(random), y = 8 * kRimPixel * unit(random);
    Point p = FlatPoint(x, y, i % 3 != 0 ? 0 : 3 * x);
    p.normal = Eigen::Vector3f(0.3F * unit(random), 0.3F * unit(random), 1).normalized();
    p.level = static_cast<std::uint8_t>(random() % 3);
    p.footprint = std::ldexp(kRimPixel, p.level);
    cloud.push_back(p);
  }
  return cloud;
}

// Of clouds with so many points each.
void ExpectTheReference(int points, int least_rims, int least_inside) {
  int rims = 0, inside = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const PointCloud cloud = CrossingSheets(seed, points);
    const std::vector<char> found = FindRims({.radius_px = 5}, cloud);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const double gap = reference::WidestGap(cloud, i, 5);
      if (std::abs(gap - kThird) < 1e-5) continue;  // rounding decides
      EXPECT_EQ(found[i] != 0, gap > kThird) << i << " of cloud " << seed << ", gap " << gap;
      (gap > kThird ? rims : inside) += 1;
    }
  }
  EXPECT_GT(rims, least_rims);
  EXPECT_GT(inside, least_inside);
}

// As many as are looked at where points are sparse, ...
TEST(FindRims, IsTheReference) { ExpectTheReference(64, 200, 200); }

// ... and dense ones.
TEST(FindRims, OfDensePointsIsTheReference) { ExpectTheReference(200, 150, 2000); }

TEST(FindRims, PointsOfWhichTooLittleIsKnownStayAndDoNotCount) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& spoil : {+[](Point*p, float v) { p->position.x() = v; },
                            +[](Point*p, float v) { p->normal.y() = v; },
                            +[](Point*p, float v) { p->sigma = v; },
                            +[](Point*p, float v) { p->footprint = v; }}) {
    PointCloud cloud = Around({0, 90, 180, 270});
    for (int i = 0; i < 3; ++i) spoil(&cloud[i], nan);
    EXPECT_EQ(FindRims({}, cloud).front(), 0);
    EXPECT_TRUE(LastIsRim(cloud));
  }
  EXPECT_TRUE(FindRims({}, {}).empty());
}

TEST(FindRims, RefusesARadiusThatIsNone) {
  for (const float radius : {0.0F, -1.0F, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    EXPECT_THROW((void)FindRims({.radius_px = radius}, {}), std::invalid_argument) << radius;
  }
}

}  // namespace
}  // namespace livemvs
