#include "livemvs/core/camera.h"

#include <gtest/gtest.h>

#include <random>

namespace livemvs {
namespace {

Camera MakeCamera(CameraModel model) {
  Camera camera{model, 640, 480, 520, 515, 318.5, 241.25, {}};
  if (model == CameraModel::kBrownConrady) {
    camera.distortion = {-0.28, 0.09, 0.0008, -0.0005, -0.012, 0.01, -0.004, 0.001};
  } else if (model == CameraModel::kKannalaBrandt) {
    camera.distortion = {-0.02, 0.006, -0.003, 0.0004};
  }
  return camera;
}

class CameraTest : public ::testing::TestWithParam<CameraModel> {};

TEST_P(CameraTest, UnprojectInvertsProject) {
  const Projector projector(MakeCamera(GetParam()));
  for (int y = 0; y < 480; y += 13) {
    for (int x = 0; x < 640; x += 13) {
      const auto ray = projector.Unproject({x, y});
      ASSERT_TRUE(ray.has_value()) << x << ' ' << y;
      const auto pixel = projector.Project(*ray * 2.5);
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR(pixel->x(), x, 1e-6);
      EXPECT_NEAR(pixel->y(), y, 1e-6);
    }
  }
}

TEST_P(CameraTest, JacobianMatchesNumericDerivative) {
  const Camera camera = MakeCamera(GetParam());
  constexpr double kStep = 1e-6;
  constexpr double kTolerance = 1e-8;
  VisitModel(GetParam(), [&](auto model) {
    using Model = decltype(model);
    const double* k = camera.distortion.data();
    for (double y = -0.45; y < 0.5; y += 0.1) {
      for (double x = -0.6; x < 0.65; x += 0.1) {
        const auto p = Model::Distort(k, x, y);
        const auto px = Model::Distort(k, x + kStep, y), mx = Model::Distort(k, x - kStep, y);
        const auto py = Model::Distort(k, x, y + kStep), my = Model::Distort(k, x, y - kStep);
        EXPECT_NEAR(p.xx, (px.x - mx.x) / (2 * kStep), kTolerance);
        EXPECT_NEAR(p.xy, (py.x - my.x) / (2 * kStep), kTolerance);
        EXPECT_NEAR(p.yx, (px.y - mx.y) / (2 * kStep), kTolerance);
        EXPECT_NEAR(p.yy, (py.y - my.y) / (2 * kStep), kTolerance);
      }
    }
  });
}

TEST_P(CameraTest, BearingPerPixelMatchesNumericDerivative) {
  const Camera camera = MakeCamera(GetParam());
  const Projector projector(camera);
  constexpr double kStep = 1e-3;
  for (int v = 20; v < 480; v += 55) {
    for (int u = 20; u < 640; u += 75) {
      const Eigen::Vector3d ray = *projector.Unproject({u, v});
      const Eigen::Matrix2d derivative = BearingPerPixel(camera, ray.x(), ray.y());
      for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis), at(u, v);
        const Eigen::Vector3d change =
            (*projector.Unproject(at + step) - *projector.Unproject(at - step)) / (2 * kStep);
        EXPECT_LT((derivative.col(axis) - change.head<2>()).norm(), 1e-6 * derivative.norm());
      }
    }
  }
}

TEST_P(CameraTest, PointsBehindTheCameraHaveNoPixel) {
  const Projector projector(MakeCamera(GetParam()));
  EXPECT_FALSE(projector.Project({0.1, 0.1, -1}).has_value());
  EXPECT_FALSE(projector.Project({0.1, 0.1, 0}).has_value());
  EXPECT_FALSE(projector.Project({0.1, 0.1, std::nan("")}).has_value());
}

INSTANTIATE_TEST_SUITE_P(Models,
                         CameraTest,
                         ::testing::Values(CameraModel::kPinhole,
                                           CameraModel::kBrownConrady,
                                           CameraModel::kKannalaBrandt),
                         [](const auto& param_info) {
                           return param_info.param == CameraModel::kPinhole ? "Pinhole"
                                  : param_info.param == CameraModel::kBrownConrady
                                      ? "BrownConrady"
                                      : "KannalaBrandt";
                         });

TEST(CameraTest, StrongBarrelDistortionEndsWhereItFolds) {
  Camera camera = MakeCamera(CameraModel::kBrownConrady);
  camera.distortion = {-0.3};
  // x (1 - 0.3 x²) is largest at x² = 1 / 0.9.
  EXPECT_LT(MaxValidRadius2(camera), 1 / 0.9);
  EXPECT_GT(MaxValidRadius2(camera), 0.8);
  EXPECT_FALSE(Projector(camera).Project({1.2, 0, 1}).has_value());
  EXPECT_FALSE(Projector(camera).Unproject({318.5 + 520 * 0.9, 241.25}).has_value());
}

TEST(CameraTest, CheckNamesTheField) {
  Camera camera = MakeCamera(CameraModel::kPinhole);
  EXPECT_NO_THROW(camera.Check());
  camera.fy = -515;
  EXPECT_NO_THROW(camera.Check()) << "old data sets have the image upside down";
  camera.fx = 0;
  EXPECT_THROW(camera.Check(), std::invalid_argument);
  camera.fx = std::nan("");
  EXPECT_THROW(camera.Check(), std::invalid_argument);
  camera = MakeCamera(CameraModel::kPinhole);
  camera.width = 0;
  EXPECT_THROW(camera.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
