#include "livemvs/synth/camera_path.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

namespace livemvs {
namespace {

double AngleDeg(const Rigid3d& a, const Rigid3d& b) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.rotation * b.rotation.transpose()));
  return std::abs(turn.angle()) * 180 / M_PI;
}

TEST(CameraPath, LookAtPutsTheTargetOnTheAxisAndWorldUpUpwards) {
  const Eigen::Vector3d eye(0.4, -0.3, 0.5), target(0.1, 0.05, 0.02);
  const Rigid3d pose = LookAt(eye, target);
  EXPECT_NEAR((pose * target).head<2>().norm(), 0, 1e-12);
  EXPECT_NEAR((pose * target).z(), (target - eye).norm(), 1e-12);
  EXPECT_LT((pose.Center() - eye).norm(), 1e-12);
  EXPECT_LT((pose.rotation * Eigen::Vector3d::UnitZ()).y(), 0);  // y is down
  EXPECT_NEAR(pose.rotation.determinant(), 1, 1e-12);
}

class PathOfScene : public testing::TestWithParam<const char*> {};

TEST_P(PathOfScene, RotationsAreExactAndStepsAreSmall) {
  const PathOptions options = DefaultPath(GetParam());
  const auto poses = MakePath(options);
  ASSERT_EQ(static_cast<int>(poses.size()), options.frames);
  const bool steady = options.kind == PathKind::kHemisphere;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Matrix3d& r = poses[i].rotation;
    EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(r.determinant(), 1, 1e-12);
    if (i == 0 || steady) continue;
    // A hand moves at walking pace at most, at 30 frames per second.
    EXPECT_LT((poses[i].Center() - poses[i - 1].Center()).norm(), 0.05) << i;
    EXPECT_LT(AngleDeg(poses[i], poses[i - 1]), 2.5) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         PathOfScene,
                         testing::Values("table", "house", "relief", "room", "plane"));

TEST(CameraPath, OrbitGoesAroundByItsArc) {
  PathOptions options;
  options.arc_deg = 90;
  options.wobble = 0;
  const auto poses = MakePath(options);
  const Eigen::Vector3d a = poses.front().Center() - options.target;
  const Eigen::Vector3d b = poses.back().Center() - options.target;
  EXPECT_NEAR(a.z(), options.height, 1e-12);
  EXPECT_NEAR(a.head<2>().norm(), options.radius, 1e-12);
  EXPECT_NEAR(a.head<2>().dot(b.head<2>()), 0, 1e-12);
}

TEST(CameraPath, WobbleMovesTheHandByMillimetresAndDependsOnTheSeed) {
  PathOptions options;
  options.frames = 300;
  PathOptions steady = options, other = options;
  steady.wobble = 0;
  other.seed = 2;
  const auto a = MakePath(options), b = MakePath(steady), c = MakePath(other);
  double moved = 0, differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    moved = std::max(moved, (a[i].Center() - b[i].Center()).norm());
    differs = std::max(differs, (a[i].Center() - c[i].Center()).norm());
  }
  EXPECT_GT(moved, 0.005);
  EXPECT_LT(moved, 0.15);
  EXPECT_GT(differs, 0.002);
}

TEST(CameraPath, HemisphereViewsAreAtTheRadiusAndAboveTheTarget) {
  const PathOptions options = DefaultPath("relief");
  EXPECT_EQ(options.frames, 312);
  for (const Rigid3d& pose : MakePath(options)) {
    const Eigen::Vector3d from_target = pose.Center() - options.target;
    EXPECT_NEAR(from_target.norm(), options.radius, 1e-9);
    EXPECT_GT(from_target.z(), 0);
  }
}

TEST(CameraPath, PosesBetweenFramesLieBetweenThem) {
  const PathOptions options;
  const Eigen::Vector3d a = PoseAt(options, 10).Center(), b = PoseAt(options, 11).Center();
  EXPECT_LT((PoseAt(options, 10.5).Center() - (a + b) / 2).norm(), 0.1 * (b - a).norm());
}

TEST(CameraPath, RejectsNonsense) {
  PathOptions options;
  options.frames = 0;
  EXPECT_THROW(MakePath(options), std::invalid_argument);
  options = {};
  options.arc_deg = NAN;
  EXPECT_THROW(MakePath(options), std::invalid_argument);
  EXPECT_THROW(PathKindFromName("spiral"), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
