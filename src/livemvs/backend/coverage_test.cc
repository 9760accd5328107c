#include "livemvs/backend/cpu/coverage.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace livemvs {
namespace {

PosedCamera FrameAt(const Eigen::Vector3d& center, double yaw) {
  PosedCamera frame;
  frame.camera.width = 160;
  frame.camera.height = 120;
  frame.camera.fx = frame.camera.fy = 130;
  frame.camera.cx = 79.5;
  frame.camera.cy = 59.5;
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix();
  frame.cam_from_world = Rigid3d{rotation, -rotation * center};
  return frame;
}

// Points all round, in the order in which a moving camera finds them.
PointCloud CloudAllRound(std::size_t size) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0, 1);
  PointCloud points(size);
  for (std::size_t i = 0; i < size; ++i) {
    const auto angle = static_cast<float>(i) * 6.28F / static_cast<float>(size);
    Point& p = points[i];
    p.position = {3 * std::sin(angle) + 0.2F * normal(random),
                  0.5F * normal(random),
                  3 * std::cos(angle) + 0.2F * normal(random)};
    p.normal = -p.position.normalized();
    p.footprint = 0.02F;
  }
  return points;
}

class CoverageTest : public ::testing::Test {
 protected:
  CoverageTest() : full_(160, 120), half_(80, 60), pyramid_{full_.view(), half_.view()} {}

  Image<std::uint8_t> full_, half_;
  std::vector<ImageView<std::uint8_t>> pyramid_;
};

TEST_F(CoverageTest, PassingOverWhatIsOutOfViewChangesNothing) {
  const PointCloud points = CloudAllRound(20'000);
  Coverage coverage(50);
  for (const double yaw : {0.0, 1.0, 2.5, 4.0}) {
    const PosedCamera frame = FrameAt({0.3, 0.1, -0.2}, yaw);
    coverage.Reset(pyramid_);
    coverage.MarkPoints(frame, points);
    int marked = 0;
    Image<std::uint8_t> expected(160, 120);
    const Projector projector(frame.camera);
    for (const Point& p : points) {
      const Eigen::Vector3d in_cam = frame.cam_from_world * p.position.cast<double>();
      const auto pixel = projector.Project(in_cam);
      // The border and halves may be rounded either way.
      if (!pixel || !frame.camera.Contains(*pixel, 1)) continue;
      const double facing = (frame.cam_from_world.Center() - p.position.cast<double>())
                                .normalized()
                                .dot(p.normal.cast<double>());
      if (facing < std::cos(50 * M_PI / 180) || p.footprint > 1.5 * in_cam.norm() / 130) continue;
      const Eigen::Vector2i at(std::lround(pixel->x()), std::lround(pixel->y()));
      bool near = false;
      for (int v = -1; v <= 1; ++v) {
        for (int u = -1; u <= 1; ++u) {
          near = near || coverage.marks()[0].view()(at.x() + u, at.y() + v) != 0;
          expected(at.x() + u, at.y() + v) = 1;
        }
      }
      EXPECT_TRUE(near) << yaw << ": " << pixel->transpose();
      ++marked;
    }
    EXPECT_GT(marked, 200) << yaw;
    int unexpected = 0;
    for (int y = 2; y < 118; ++y) {
      for (int x = 2; x < 158; ++x) {
        unexpected += coverage.marks()[0].view()(x, y) != 0 && expected(x, y) == 0;
      }
    }
    // Points that just face the camera, or are just fine enough, may be judged either way.
    EXPECT_LE(unexpected, marked / 100) << yaw;
  }
}

TEST_F(CoverageTest, CoarsePointsMarkCoarseLevelsOnly) {
  const PosedCamera frame = FrameAt({0, 0, 0}, 0);
  Point point;
  point.position = {0, 0, 2};
  point.normal = {0, 0, -1};
  for (const auto& [footprint, fine, coarse] :
       {std::tuple{0.01F, 1, 1}, std::tuple{0.04F, 0, 1}, std::tuple{0.1F, 0, 0}}) {
    point.footprint = footprint;  // a pixel is 2 / 130 = 0.0154 wide there
    Coverage coverage(50);
    coverage.Reset(pyramid_);
    coverage.MarkPoints(frame, {&point, 1});
    int at_fine = 0, at_coarse = 0;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) at_fine += coverage.marks()[0].view()(x, y);
    }
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 80; ++x) at_coarse += coverage.marks()[1].view()(x, y);
    }
    EXPECT_EQ(at_fine, fine) << footprint;
    EXPECT_EQ(at_coarse, coarse) << footprint;
  }
}

TEST_F(CoverageTest, NewPointsAreSeenAndForgottenOnesAreNot) {
  const PosedCamera frame = FrameAt({0, 0, 0}, 0);
  PointCloud points = CloudAllRound(1000);
  Coverage coverage(50);
  const auto count = [&] {
    coverage.Reset(pyramid_);
    coverage.MarkPoints(frame, points);
    int n = 0;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) n += coverage.marks()[0].view()(x, y);
    }
    return n;
  };
  const int before = count();
  Point point;
  point.position = {0.4F, 0.9F, 2};
  point.normal = -point.position.normalized();
  point.footprint = 0.01F;
  for (int n = 0; n < 600; ++n) {
    point.position.x() += 0.0005F;
    points.push_back(point);
  }
  EXPECT_GT(count(), before);
  points.clear();
  coverage.Forget();
  EXPECT_EQ(count(), 0);
}

}  // namespace
}  // namespace livemvs
