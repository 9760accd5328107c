#include "livemvs/core/scene_range.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Camera kCamera{CameraModel::kPinhole, 640, 480, 500, 500, 319.5, 239.5, {}};

// cam_from_world of a camera at `eye` that looks at `target`; y is down.
Rigid3d LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = Eigen::Vector3d(0, 1, 0).cross(z).normalized();
  Rigid3d pose;
  pose.rotation.row(0) = x.transpose();
  pose.rotation.row(1) = z.cross(x).transpose();
  pose.rotation.row(2) = z.transpose();
  pose.translation = -(pose.rotation * eye);
  return pose;
}

std::vector<PosedCamera> Orbit(double radius, const Eigen::Vector3d& target) {
  std::vector<PosedCamera> cameras;
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.03 * i;
    const Eigen::Vector3d eye =
        target + radius * Eigen::Vector3d(std::sin(angle), 0, -std::cos(angle));
    cameras.push_back({kCamera, LookAt(eye, target)});
  }
  return cameras;
}

SceneRange Range(double near, double far) {
  SceneRange range;
  range.near = near;
  range.far = far;
  return range;
}

TEST(SceneRangeTest, CheckRefusesEmptyAndNotFinite) {
  EXPECT_NO_THROW(Range(0.1, 2).Check());
  EXPECT_THROW(Range(2, 2).Check(), std::invalid_argument);
  EXPECT_THROW(Range(3, 2).Check(), std::invalid_argument);
  EXPECT_THROW(Range(0, 2).Check(), std::invalid_argument);
  EXPECT_THROW(Range(-1, 2).Check(), std::invalid_argument);
  EXPECT_THROW(Range(kNan, 2).Check(), std::invalid_argument);
  EXPECT_THROW(Range(1, kNan).Check(), std::invalid_argument);
  EXPECT_THROW(Range(1, kInfinity).Check(), std::invalid_argument);
  SceneRange range = Range(1, 2);
  range.box = Box{{0, 0, 0}, {1, 0, 1}};
  EXPECT_THROW(range.Check(), std::invalid_argument);
  range.box = Box{{0, 0, 0}, {1, kNan, 1}};
  EXPECT_THROW(range.Check(), std::invalid_argument);
  range.box = Box{{0, 0, 0}, {1, kInfinity, 1}};
  EXPECT_THROW(range.Check(), std::invalid_argument);
}

TEST(SceneRangeTest, NearAndFarArePlanarDepths) {
  const auto along = Range(1, 3).Along({0, 0, 0}, {0.6, 0, 0.8}, 0.8);
  ASSERT_TRUE(along);
  EXPECT_NEAR(along->first, 1.25, 1e-12);
  EXPECT_NEAR(along->second, 3.75, 1e-12);
}

TEST(SceneRangeTest, RayThroughTheBoxByMarching) {
  SceneRange range = Range(1e-3, 100);
  range.box = Box{{-1, 0, 2}, {1, 0.5, 4}};
  range.margin = 0.05;
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  int hits = 0;
  for (int n = 0; n < 2000; ++n) {
    const Eigen::Vector3d center(gauss(random), gauss(random), gauss(random));
    const Eigen::Vector3d direction =
        Eigen::Vector3d(0.4 * gauss(random), 0.4 * gauss(random), 1).normalized();
    constexpr double kStep = 0.002;
    double first = -1, last = -1;
    for (double s = 0.002; s < 12; s += kStep) {
      if (!range.SoughtBox()->Contains(center + s * direction)) continue;
      if (first < 0) first = s;
      last = s;
    }
    const auto along = range.Along(center, direction, direction.z());
    if (first < 0) {
      EXPECT_TRUE(!along || along->second - along->first < 2 * kStep);
      continue;
    }
    ++hits;
    ASSERT_TRUE(along);
    EXPECT_NEAR(along->first, first, 2 * kStep);
    EXPECT_NEAR(along->second, last, 2 * kStep);
  }
  EXPECT_GT(hits, 200);
}

TEST(SceneRangeTest, RaysParallelToAFace) {
  SceneRange range = Range(0.1, 100);
  range.box = Box{{-1, -1, 2}, {1, 1, 4}};
  const auto along = range.Along({0.5, 0.5, 0}, {0, 0, 1}, 1);
  ASSERT_TRUE(along);
  EXPECT_DOUBLE_EQ(along->first, 2);
  EXPECT_DOUBLE_EQ(along->second, 4);
  EXPECT_FALSE(range.Along({1.5, 0.5, 0}, {0, 0, 1}, 1));
  EXPECT_FALSE(range.Along({0, 0, 5}, {0, 0, 1}, 1)) << "the box lies behind";
  EXPECT_DOUBLE_EQ(range.Along({0, 0, 3}, {0, 0, 1}, 1)->first, 0.1) << "from inside: near";
}

TEST(SceneRangeTest, SeeksBeyondTheBoxByTheMargin) {
  SceneRange range = Range(0.1, 100);
  range.margin = 0.25;
  EXPECT_FALSE(range.SoughtBox());
  range.box = Box{{-1, -1, 2}, {1, 1, 4}};
  EXPECT_EQ(range.SoughtBox()->min, Eigen::Vector3d(-1.25, -1.25, 1.75));
  EXPECT_EQ(range.SoughtBox()->max, Eigen::Vector3d(1.25, 1.25, 4.25));
  range.margin = -0.1;
  EXPECT_THROW(range.Check(), std::invalid_argument);
}

TEST(RangeOfBoxTest, HoldsTheSoughtBoxFromAllCameras) {
  const Box box{{-0.2, -0.1, -0.2}, {0.2, 0.1, 0.2}};
  const auto cameras = Orbit(1.5, {0, 0, 0});
  const SceneRange range = RangeOfBox(box, 0.02, cameras);
  EXPECT_NO_THROW(range.Check());
  for (const PosedCamera& c : cameras) {
    for (int k = 0; k < 8; ++k) {
      const Box sought = *range.SoughtBox();
      const Eigen::Vector3d p((k & 1 ? sought.max : sought.min).x(),
                              (k & 2 ? sought.max : sought.min).y(),
                              (k & 4 ? sought.max : sought.min).z());
      const double z = (c.cam_from_world * p).z();
      EXPECT_GT(z, range.near);
      EXPECT_LT(z, range.far);
    }
  }
  EXPECT_GT(range.near, 1);
  EXPECT_LT(range.far, 2);
  EXPECT_THROW(RangeOfBox(Box{{-1, -1, -9}, {1, 1, -8}}, 0, {{kCamera, Rigid3d{}}}), Error);
}

TEST(DeriveRangeTest, OrbitLooksAtItsTarget) {
  const SceneRange range = DeriveRange(Orbit(0.8, {3, 1, 2}), {});
  EXPECT_NO_THROW(range.Check());
  EXPECT_LT(range.near, 0.7);
  EXPECT_GT(range.near, 0.1);
  EXPECT_GT(range.far, 0.9);
  EXPECT_LT(range.far, 4);
  EXPECT_FALSE(range.origin.empty());
}

TEST(DeriveRangeTest, ScalesWithTheScene) {
  const SceneRange small = DeriveRange(Orbit(0.8, {3, 1, 2}), {});
  const SceneRange large = DeriveRange(Orbit(800, {3000, 1000, 2000}), {});
  EXPECT_NEAR(large.near / small.near, 1000, 1e-6);
  EXPECT_NEAR(large.far / small.far, 1000, 1e-6);
}

TEST(DeriveRangeTest, ForwardWalkHasARangeOfItsPath) {
  std::vector<PosedCamera> cameras;
  for (int i = 0; i < 50; ++i) {
    cameras.push_back({kCamera, Rigid3d{Eigen::Matrix3d::Identity(), {0, 0, -0.05 * i}}});
  }
  const SceneRange range = DeriveRange(cameras, {});
  EXPECT_NO_THROW(range.Check());
  EXPECT_LT(range.near, 2.45);
  EXPECT_GT(range.far, 2.45);
}

TEST(DeriveRangeTest, SparsePointsDecideWhereThereAreEnough) {
  const auto cameras = Orbit(0.8, {0, 0, 0});
  std::mt19937 random(2);
  std::uniform_real_distribution<double> side(-0.1, 0.1);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i) points.emplace_back(side(random), side(random), side(random));
  const SceneRange range = DeriveRange(cameras, points);
  EXPECT_NO_THROW(range.Check());
  for (const PosedCamera& c : cameras) {
    for (const Eigen::Vector3d& p : points) {
      EXPECT_GT((c.cam_from_world * p).z(), range.near);
      EXPECT_LT((c.cam_from_world * p).z(), range.far);
    }
  }
  EXPECT_LT(range.far - range.near, 1.2) << "narrower than the guess from the cameras alone";
  points.resize(1);
  points[0] = {kNan, 0, 0};
  EXPECT_NO_THROW(DeriveRange(cameras, points).Check());
}

TEST(DeriveRangeTest, StillCamerasAreAnError) {
  EXPECT_THROW(DeriveRange({{kCamera, Rigid3d{}}, {kCamera, Rigid3d{}}}, {}), Error);
  EXPECT_THROW(DeriveRange({}, {}), Error);
}

}  // namespace
}  // namespace livemvs
