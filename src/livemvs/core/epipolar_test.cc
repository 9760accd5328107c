#include "livemvs/core/epipolar.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <tuple>

namespace livemvs {
namespace {

Camera CameraOf(CameraModel model) {
  Camera camera{model, 640, 480, 520, 515, 318.5, 241.25, {}};
  if (model == CameraModel::kBrownConrady) {
    camera.distortion = {-0.28, 0.09, 0.0008, -0.0005, -0.012, 0.01, -0.004, 0.001};
  } else if (model == CameraModel::kKannalaBrandt) {
    camera.distortion = {-0.02, 0.006, -0.003, 0.0004};
  }
  return camera;
}

Rigid3d Pose(double turn, const Eigen::Vector3d& axis, const Eigen::Vector3d& translation) {
  return {Eigen::AngleAxisd(turn, axis.normalized()).toRotationMatrix(), translation};
}

using Parameters = std::tuple<CameraModel, DepthCoordinate>;

class EpipolarTest : public ::testing::TestWithParam<Parameters> {
 protected:
  struct Case {
    double bx, by, mu;
    Interval<double> interval;
  };

  EpipolarTest() { view_ = MakeRelativeView<double>(ref_, ref_from_world_, cur_, cur_from_world_); }

  Case Next() {
    std::uniform_real_distribution<double> side(-0.35, 0.35), near(0.6, 1), ratio(1.3, 5),
        mu(0.1, 0.9);
    const double z0 = near(random_), z1 = z0 * ratio(random_);
    const bool depth = std::get<1>(GetParam()) == DepthCoordinate::kDepth;
    return {side(random_), side(random_), mu(random_), {depth ? z0 : 1 / z0, depth ? z1 : 1 / z1}};
  }

  // Through the world, by the class that io and the reports use.
  std::optional<Eigen::Vector2d> Expected(const Case& c, double mu) const {
    const double coordinate = c.interval.c0 + mu * (c.interval.c1 - c.interval.c0);
    const double depth =
        std::get<1>(GetParam()) == DepthCoordinate::kDepth ? coordinate : 1 / coordinate;
    const Eigen::Vector3d bearing = Eigen::Vector3d(c.bx, c.by, 1).normalized();
    return projector_.Project(cur_from_world_ * (ref_from_world_.Inverse() * (bearing * depth)));
  }

  Projection<double> Project(const Case& c, double mu) const {
    return VisitModel(cur_.model, [&](auto model) {
      return ProjectSeed<decltype(model)>(
          view_, std::get<1>(GetParam()), c.interval, c.bx, c.by, mu);
    });
  }

  std::mt19937 random_{11};
  Camera ref_ = CameraOf(std::get<0>(GetParam()));
  Camera cur_ = CameraOf(std::get<0>(GetParam()));
  Projector projector_{cur_};
  Rigid3d ref_from_world_ = Pose(0.3, {1, 2, 3}, {0.1, -0.2, 0.3});
  Rigid3d cur_from_world_ = Pose(0.08, {1, -1, 0.5}, {0.05, 0.04, -0.06}) * ref_from_world_;
  RelativeView<double> view_{};
};

TEST_P(EpipolarTest, ProjectionIsTheProjectorsThroughTheWorld) {
  int visible = 0;
  for (int n = 0; n < 2000; ++n) {
    const Case c = Next();
    const auto expected = Expected(c, c.mu);
    const Projection<double> p = Project(c, c.mu);
    ASSERT_EQ(p.visible, expected.has_value()) << n;
    if (!expected) continue;
    ++visible;
    ASSERT_NEAR(p.x, expected->x(), 1e-9) << n;
    ASSERT_NEAR(p.y, expected->y(), 1e-9) << n;
  }
  EXPECT_GT(visible, 1500);
}

TEST_P(EpipolarTest, RateAndDirectionAreTheDerivative) {
  constexpr double kStep = 1e-5;
  for (int n = 0; n < 1000; ++n) {
    const Case c = Next();
    const auto ahead = Expected(c, c.mu + kStep), behind = Expected(c, c.mu - kStep);
    const Projection<double> p = Project(c, c.mu);
    if (!p.visible || !ahead || !behind) continue;
    const Eigen::Vector2d velocity = (*ahead - *behind) / (2 * kStep);
    ASSERT_NEAR(p.rate, velocity.norm(), 1e-6 * velocity.norm()) << n;
    ASSERT_NEAR(p.dx, velocity.x() / velocity.norm(), 1e-6) << n;
    ASSERT_NEAR(p.dy, velocity.y() / velocity.norm(), 1e-6) << n;
  }
}

TEST_P(EpipolarTest, MuStepLeadsToTheOffset) {
  // Exact for a pinhole; lens distortion bends and stretches the line a little within the window.
  const double tolerance_px = std::get<0>(GetParam()) == CameraModel::kPinhole ? 1e-7 : 0.1;
  for (int n = 0; n < 1000; ++n) {
    const Case c = Next();
    const Projection<double> p = Project(c, c.mu);
    if (!p.visible || p.rate < 20) continue;
    for (const double offset : {-8.0, -2.5, 0.3, 6.0}) {
      const double step = MuStep(p, offset);
      if (std::abs(step) > 0.5) continue;  // beyond the interval
      const auto reached = Expected(c, c.mu + step);
      ASSERT_TRUE(reached.has_value());
      ASSERT_NEAR(reached->x(), p.x + offset * p.dx, tolerance_px) << n << ' ' << offset;
      ASSERT_NEAR(reached->y(), p.y + offset * p.dy, tolerance_px) << n << ' ' << offset;
    }
  }
}

TEST_P(EpipolarTest, OffsetOfMuStepInvertsMuStep) {
  for (int n = 0; n < 1000; ++n) {
    const Case c = Next();
    const Projection<double> p = Project(c, c.mu);
    if (!p.visible || p.rate < 20) continue;
    for (const double offset : {-8.0, -0.5, 0.0, 3.0, 8.0}) {
      EXPECT_NEAR(OffsetOfMuStep(p, MuStep(p, offset)), offset, 1e-9);
    }
  }
}

TEST_P(EpipolarTest, SearchStaysInThePictureTheIntervalAndTheWindow) {
  constexpr double kRadius = 6, kMargin = 4;
  int searched = 0;
  std::uniform_real_distribution<double> wide(-0.75, 0.75);
  for (int n = 0; n < 5000; ++n) {
    Case c = Next();
    c.bx = wide(random_);
    c.by = wide(random_);
    const Projection<double> p = Project(c, c.mu);
    if (!p.visible) continue;
    const SearchRange<double> range = ClipSearch(view_, p, c.mu, kRadius, kMargin);
    for (int i = static_cast<int>(range.first); i <= range.last; ++i) {
      ++searched;
      ASSERT_LE(std::abs(i), kRadius + 1);
      const Eigen::Vector2d sample(p.x + i * p.dx, p.y + i * p.dy);
      ASSERT_TRUE(cur_.Contains(sample, kMargin - 1e-9)) << sample.transpose();
      // One sample to spare beyond the ends of the interval, so that these can be maxima.
      const double from = OffsetOfMuStep(p, -c.mu), to = OffsetOfMuStep(p, 1 - c.mu);
      ASSERT_GE(i, from - 1 - 1e-9);
      ASSERT_LE(i, to + 1 + 1e-9);
    }
  }
  EXPECT_GT(searched, 1000);
}

TEST_P(EpipolarTest, FloatFollowsDouble) {
  // 24 bits over a picture 640 px wide, through a handful of operations.
  constexpr double kTolerancePx = 1e-3;
  const auto view = MakeRelativeView<float>(ref_, ref_from_world_, cur_, cur_from_world_);
  for (int n = 0; n < 1000; ++n) {
    const Case c = Next();
    const Projection<double> p = Project(c, c.mu);
    const auto f = VisitModel(cur_.model, [&](auto model) {
      return ProjectSeed<decltype(model), float>(
          view,
          std::get<1>(GetParam()),
          {static_cast<float>(c.interval.c0), static_cast<float>(c.interval.c1)},
          static_cast<float>(c.bx),
          static_cast<float>(c.by),
          static_cast<float>(c.mu));
    });
    if (!p.visible) continue;
    ASSERT_NEAR(f.x, p.x, kTolerancePx);
    ASSERT_NEAR(f.y, p.y, kTolerancePx);
    ASSERT_NEAR(f.rate, p.rate, 1e-4 * p.rate);
  }
}

TEST_P(EpipolarTest, BehindTheCameraIsNotVisible) {
  const Rigid3d turned = Pose(M_PI, {0, 1, 0}, {0, 0, 0}) * ref_from_world_;
  view_ = MakeRelativeView<double>(ref_, ref_from_world_, cur_, turned);
  for (int n = 0; n < 100; ++n) {
    const Case c = Next();
    EXPECT_FALSE(Project(c, c.mu).visible);
  }
}

TEST_P(EpipolarTest, WithoutABaselineTheRateIsZero) {
  const Rigid3d turned = Pose(0.1, {1, 2, 0.3}, {0, 0, 0}) * ref_from_world_;
  view_ = MakeRelativeView<double>(ref_, ref_from_world_, cur_, turned);
  for (int n = 0; n < 100; ++n) {
    const Case c = Next();
    const Projection<double> p = Project(c, c.mu);
    if (!p.visible) continue;
    EXPECT_LT(p.rate, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(ModelsAndCoordinates,
                         EpipolarTest,
                         ::testing::Combine(::testing::Values(CameraModel::kPinhole,
                                                              CameraModel::kBrownConrady,
                                                              CameraModel::kKannalaBrandt),
                                            ::testing::Values(DepthCoordinate::kDepth,
                                                              DepthCoordinate::kInverseDepth)));

TEST(RelativeViewTest, RollIsTheRotationOfThePicture) {
  const Camera camera = CameraOf(CameraModel::kPinhole);
  for (const double roll : {-2.0, -0.3, 0.0, 0.7, 3.0}) {
    const auto view =
        MakeRelativeView<double>(camera, {}, camera, Pose(roll, {0, 0, 1}, {0, 0, 0}));
    EXPECT_NEAR(std::atan2(view.roll_sin, view.roll_cos), roll, 1e-12);
  }
  Camera far = camera;
  far.fx *= 2;
  far.fy *= 2;
  EXPECT_NEAR(MakeRelativeView<double>(camera, {}, far, {}).focal_ratio, 2, 1e-12);
}

TEST(ClipOffsetsTest, ParallelLinesAreKeptOrEmptied) {
  double lo = -5, hi = 5;
  ClipOffsets(3.0, 0.0, 0.0, 10.0, &lo, &hi);
  EXPECT_EQ(lo, -5);
  EXPECT_EQ(hi, 5);
  ClipOffsets(-3.0, 0.0, 0.0, 10.0, &lo, &hi);
  EXPECT_LT(hi, lo);
  lo = -5;
  hi = 5;
  // A picture narrower than twice the margin has no place for the patch.
  lo = -10;
  hi = 10;
  ClipOffsets(7.0, 1.0, 12.8, 2.2, &lo, &hi);
  EXPECT_LT(hi, lo);
  lo = -10;
  hi = 10;
  ClipOffsets(1.0, -1.0, 0.0, 3.0, &lo, &hi);
  EXPECT_EQ(lo, -2);
  EXPECT_EQ(hi, 1);
}

}  // namespace
}  // namespace livemvs
