#include "livemvs/map/overhang.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "livemvs/core/lean.h"
#include "livemvs/reference/overhang.h"

namespace livemvs {
namespace {

constexpr float kPixel = 0.01F;
const Eigen::Vector3f kTowardsCamera(0, 0, 1);
const Eigen::Vector3f kLeft(-1, 0, 0), kRight(1, 0, 0);

// Seen from +z.
Point At(float x, float y, float z) {
  Point p;
  p.position = {x, y, z};
  p.normal = kTowardsCamera;
  p.sigma = 0.1F * kPixel;
  p.footprint = kPixel;
  p.lean = kLeanNowhere;
  return p;
}

Point Leaning(float x, float y, float z, const Eigen::Vector3f& towards) {
  Point p = At(x, y, z);
  p.lean = LeanCode(kTowardsCamera, towards);
  return p;
}

// Five points with texture all around, a pixel apart along y.
void AddEdge(float x, float z, PointCloud* cloud) {
  for (int i = -2; i <= 2; ++i) cloud->push_back(At(x, kPixel * static_cast<float>(i), z));
}

// Of the last point, which the others do not hold down.
bool LastOverhangs(const PointCloud& cloud) { return FindOverhanging({}, cloud).back() != 0; }

TEST(FindOverhanging, PointsStayBetweenTwoEdgesOfASurface) {
  PointCloud cloud;
  AddEdge(0, 0, &cloud);
  AddEdge(20 * kPixel, 0, &cloud);
  // A plain strip from one edge to the other; the texture is that of the edge that is nearer.
  cloud.push_back(Leaning(2 * kPixel, 0, 0, kLeft));
  cloud.push_back(Leaning(18 * kPixel, 0, 0, kRight));
  EXPECT_EQ(FindOverhanging({}, cloud), std::vector<char>(cloud.size(), 0));
}

TEST(FindOverhanging, PointsGoBeyondTheLastEdge) {
  PointCloud cloud;
  AddEdge(0, 0, &cloud);
  AddEdge(20 * kPixel, 0, &cloud);
  cloud.push_back(Leaning(-2 * kPixel, 0, 0, kRight));
  EXPECT_TRUE(LastOverhangs(cloud));
  cloud.back() = Leaning(22 * kPixel, 0, 0, kLeft);
  EXPECT_TRUE(LastOverhangs(cloud));
  EXPECT_EQ(FindOverhanging({}, cloud).front(), 0);
}

TEST(FindOverhanging, WhatLiesFarBehindDoesNotAgree) {
  // The edge of something near, and beside it, in the picture, what is behind.
  PointCloud cloud;
  AddEdge(0, 0, &cloud);
  AddEdge(-10 * kPixel, -30 * kPixel, &cloud);
  cloud.push_back(Leaning(-2 * kPixel, 0, 0, kRight));
  EXPECT_TRUE(LastOverhangs(cloud));
  // A slope of up to two is a surface, though.
  PointCloud slope;
  AddEdge(0, 0, &slope);
  AddEdge(-10 * kPixel, -12 * kPixel, &slope);
  slope.push_back(Leaning(-2 * kPixel, 0, 0, kRight));
  EXPECT_FALSE(LastOverhangs(slope));
}

TEST(FindOverhanging, ThreeMustAgree) {
  PointCloud cloud = {At(10 * kPixel, 0, 0), At(11 * kPixel, 0, 0)};
  cloud.push_back(Leaning(0, 0, 0, kLeft));
  EXPECT_TRUE(LastOverhangs(cloud));
  cloud.insert(cloud.begin(), At(30 * kPixel, kPixel, 0));
  EXPECT_FALSE(LastOverhangs(cloud));
  // Those that lean themselves do not count, or of which nothing is known.
  for (const std::uint8_t lean : {std::uint8_t{1}, kLeanUnknown}) {
    cloud.front().lean = lean;
    EXPECT_TRUE(LastOverhangs(cloud));
  }
}

TEST(FindOverhanging, ReachIsInPixelsOfTheFinestLevel) {
  PointCloud cloud;
  AddEdge(60 * kPixel, 0, &cloud);
  cloud.push_back(Leaning(0, 0, 0, kLeft));
  EXPECT_FALSE(LastOverhangs(cloud));
  EXPECT_NE(FindOverhanging({.reach_px = 50}, cloud).back(), 0);
  // Its pixels are as wide, but of a level whose pixels are four of the finest.
  cloud.back().level = 2;
  EXPECT_TRUE(LastOverhangs(cloud));
  cloud.back().footprint = 4 * kPixel;
  EXPECT_FALSE(LastOverhangs(cloud));
}

// Points of three levels on two crossing sheets; a quarter of them with texture all around.
PointCloud CrossingSheets(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    const float x = 60 * kPixel * unit(random), y = 60 * kPixel * unit(random);
    Point p = At(x, y, i % 2 == 0 ? 0 : 3 * x);
    p.normal = Eigen::Vector3f(0.3F * unit(random), 0.3F * unit(random), 1).normalized();
    p.level = static_cast<std::uint8_t>(random() % 3);
    p.footprint = std::ldexp(kPixel, p.level);
    if (i % 4 != 0) p.lean = static_cast<std::uint8_t>(1 + random() % kLeanDirections);
    cloud.push_back(p);
  }
  return cloud;
}

TEST(FindOverhanging, IsTheReferenceWhereAllPointsAreLookedAt) {
  // Sixteen have texture all around: all of them are near every place.
  int overhanging = 0, held = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const PointCloud cloud = CrossingSheets(64, seed);
    const std::vector<char> found = FindOverhanging({.reach_px = 60}, cloud);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!Leans(cloud[i].lean)) {
        EXPECT_EQ(found[i], 0);
        continue;
      }
      const bool expected = reference::Supporters(cloud, i, 60) < 3;
      EXPECT_EQ(found[i] != 0, expected) << i << " of cloud " << seed;
      (expected ? overhanging : held) += 1;
    }
  }
  EXPECT_GT(overhanging, 100);
  EXPECT_GT(held, 50);
}

TEST(FindOverhanging, OverlooksFewOfThoseWhoAgree) {
  const PointCloud cloud = CrossingSheets(3000, 7);
  const std::vector<char> found = FindOverhanging({.reach_px = 40}, cloud);
  int held = 0, overlooked = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!Leans(cloud[i].lean)) continue;
    if (reference::Supporters(cloud, i, 40) < 3) {
      EXPECT_NE(found[i], 0) << i;  // who sees fewer finds no more
    } else {
      ++held;
      overlooked += found[i];
    }
  }
  ASSERT_GT(held, 1000);
  EXPECT_LT(overlooked, held / 10);
}

TEST(FindOverhanging, PointsOfWhichTooLittleIsKnownStay) {
  EXPECT_TRUE(FindOverhanging({}, {}).empty());
  PointCloud cloud(6, Leaning(0, 0, 0, kLeft));
  cloud[0].lean = kLeanUnknown;
  cloud[1].position.x() = std::numeric_limits<float>::quiet_NaN();
  cloud[2].footprint = 0;
  cloud[3].normal.y() = std::numeric_limits<float>::infinity();
  cloud[4].normal.setZero();
  cloud[5].sigma = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(FindOverhanging({}, cloud), std::vector<char>(6, 0));
}

TEST(FindOverhanging, RefusesAReachThatMakesNoSense) {
  EXPECT_THROW(static_cast<void>(FindOverhanging({.reach_px = 0}, {})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(FindOverhanging({.reach_px = std::nanf("")}, {})),
               std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
