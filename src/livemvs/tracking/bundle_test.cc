#include "livemvs/tracking/bundle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "livemvs/synth/camera_path.h"
#include "livemvs/synth/random.h"
#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/calibrator.h"
#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

constexpr double kExact = 1e-6;  // noise-free solutions, relative

Camera SomeCamera(CameraModel model = CameraModel::kBrownConrady) {
  Camera camera = SyntheticCamera(960, 720);
  camera.model = model;
  camera.fx = 870;
  camera.fy = 880;
  camera.cx = 470;
  camera.cy = 368;
  if (model == CameraModel::kBrownConrady) camera.distortion = {-0.2, 0.07, 0.001, -0.0007, 0.01};
  if (model == CameraModel::kKannalaBrandt) camera.distortion = {0.05, -0.02, 0.004, 0.001};
  return camera;
}

Rigid3d SomePose(int i) {
  const double a = 0.9 * i, r = 0.1 + 0.04 * (i % 6);
  return LookAt({r * std::cos(a), r * std::sin(a), 0.25 + 0.05 * (i % 4)},
                {0.05 * std::sin(2.3 * i), 0.04 * std::cos(1.7 * i), 0});
}

// What a camera sees of the board, bent as z = bend · (x², xy, y²).
std::vector<PointObservation> See(const Camera& camera,
                                  const Rigid3d& pose,
                                  double noise,
                                  std::uint64_t seed,
                                  const Eigen::Vector3d& bend = Eigen::Vector3d::Zero()) {
  synth::Random random(seed);
  const Projector projector(camera);
  std::vector<PointObservation> seen;
  for (const BoardCorner& corner : CornersOf(Board())) {
    Eigen::Vector3d p = corner.point;
    p.z() = bend.dot(Eigen::Vector3d(p.x() * p.x(), p.x() * p.y(), p.y() * p.y()));
    const auto pixel = projector.Project(pose * p);
    if (!pixel || !camera.Contains(*pixel, 5)) continue;
    // The sum of three uniform ones has the variance 1/4.
    const auto error = [&] {
      return 2 * noise * (random.Uniform() + random.Uniform() + random.Uniform() - 1.5);
    };
    seen.push_back({corner.point, *pixel + Eigen::Vector2d(error(), error()), 0.05});
  }
  return seen;
}

std::vector<BundleView> Views(const Camera& camera,
                              int n,
                              double noise,
                              const Eigen::Vector3d& bend) {
  std::vector<BundleView> views;
  for (int i = 0; i < n; ++i) {
    BundleView view;
    view.cam_from_world = SomePose(i);
    view.observations = See(camera, SomePose(i), noise, 100 + i, bend);
    views.push_back(view);
  }
  return views;
}

BundleOptions AllFree(const Camera& camera) {
  BundleOptions options;
  options.equal_focal = false;
  const int terms = camera.model == CameraModel::kKannalaBrandt ? 4 : 5;
  for (int i = 0; i < 4 + terms; ++i) options.free[i] = true;
  return options;
}

double Parameter(const Camera& c, int i) {
  const double linear[4] = {c.fx, c.fy, c.cx, c.cy};
  return i < 4 ? linear[i] : c.distortion[i - 4];
}

void Set(Camera* c, int i, double value) {
  double* const linear[4] = {&c->fx, &c->fy, &c->cx, &c->cy};
  (i < 4 ? *linear[i] : c->distortion[i - 4]) = value;
}

class ProjectionModels : public testing::TestWithParam<CameraModel> {};

TEST_P(ProjectionModels, DerivativesAreThoseOfDifferences) {
  Camera camera = SomeCamera(GetParam());
  if (camera.model == CameraModel::kBrownConrady) {
    camera.distortion[5] = 0.02;
    camera.distortion[6] = -0.01;
    camera.distortion[7] = 0.003;
  }
  constexpr double kStep = 1e-6, kTolerance = 2e-3;
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.1, -0.05, 0.4), Eigen::Vector3d(-0.2, 0.15, 0.6)}) {
    const PointProjection at = ProjectWithDerivatives(camera, p, true);
    EXPECT_LT((at.pixel - Projector(camera).Project(p).value()).norm(), 1e-9);
    const int count = camera.model == CameraModel::kPinhole         ? 4
                      : camera.model == CameraModel::kKannalaBrandt ? 8
                                                                    : kIntrinsics;
    for (int i = 0; i < count; ++i) {
      Camera moved = camera;
      Set(&moved, i, Parameter(camera, i) + kStep);
      const Eigen::Vector2d slope =
          (ProjectWithDerivatives(moved, p, false).pixel - at.pixel) / kStep;
      EXPECT_LT((slope - at.by_camera.col(i)).norm(), kTolerance) << "intrinsic " << i;
    }
    for (int i = 0; i < 6; ++i) {
      Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
      motion[i] = kStep;
      const Eigen::Vector3d q = Moved(Rigid3d(), motion) * p;
      const Eigen::Vector2d slope =
          (ProjectWithDerivatives(camera, q, false).pixel - at.pixel) / kStep;
      EXPECT_LT((slope - ByMotion(at, p).col(i)).norm(), 0.05) << "motion " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models,
                         ProjectionModels,
                         testing::Values(CameraModel::kPinhole,
                                         CameraModel::kBrownConrady,
                                         CameraModel::kKannalaBrandt));

TEST(BundleTest, FindsTheCameraOfPerfectViewsExactly) {
  for (const CameraModel model : {CameraModel::kBrownConrady, CameraModel::kKannalaBrandt}) {
    const Camera truth = SomeCamera(model);
    Camera start = truth;
    start.fx = start.fy = 800;
    start.cx = 479.5;
    start.cy = 359.5;
    start.distortion = {};
    const BundleResult result =
        AdjustBundle(start, Views(truth, 14, 0, Eigen::Vector3d::Zero()), AllFree(truth));
    ASSERT_TRUE(result.converged);
    EXPECT_LT(result.rms_px, 1e-4);
    EXPECT_NEAR(result.camera.fx, truth.fx, kExact * truth.fx * 10);
    EXPECT_NEAR(result.camera.cy, truth.cy, 1e-3);
    EXPECT_NEAR(result.camera.distortion[1], truth.distortion[1], 1e-4);
  }
}

TEST(BundleTest, FindsTheBendOfTheSheet) {
  const Eigen::Vector3d bend(0.05, -0.02, 0.03);  // 2 mm at the sheet's ends [1/m]
  const Camera truth = SomeCamera();
  BundleOptions options;
  options.bend = true;
  const BundleResult result = AdjustBundle(truth, Views(truth, 10, 0.05, bend), options);
  ASSERT_TRUE(result.converged);
  EXPECT_LT((result.bend - bend).norm(), 0.003);
  EXPECT_EQ(result.camera.fx, truth.fx);
}

TEST(BundleTest, GrossErrorsDoNotCount) {
  const Camera truth = SomeCamera();
  std::vector<BundleView> views = Views(truth, 12, 0.05, Eigen::Vector3d::Zero());
  for (BundleView& view : views) {
    for (std::size_t i = 0; i < view.observations.size(); i += 9)
      view.observations[i].pixel.x() += 15;
  }
  const BundleResult result = AdjustBundle(truth, views, AllFree(truth));
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.camera.fx, truth.fx, 0.002 * truth.fx);
  EXPECT_LT(result.rms_px, 0.15);
}

// OpenCV's calibration as oracle: the same minimum, and errors of the size that is stated.
TEST(BundleTest, AgreesWithOpenCvOnNoisyViews) {
  const Camera truth = SomeCamera();
  const std::vector<BundleView> views = Views(truth, 14, 0.1, Eigen::Vector3d::Zero());
  BundleOptions options = AllFree(truth);
  options.outlier_sigmas = 100;  // OpenCV knows no outliers
  options.floor_px = 0.1;
  const BundleResult ours = AdjustBundle(truth, views, options);
  ASSERT_TRUE(ours.converged);
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BundleView& view : views) {
    points.emplace_back();
    pixels.emplace_back();
    for (const PointObservation& o : view.observations) {
      points.back().emplace_back(
          static_cast<float>(o.point.x()), static_cast<float>(o.point.y()), 0.F);
      pixels.back().emplace_back(static_cast<float>(o.pixel.x()), static_cast<float>(o.pixel.y()));
    }
  }
  cv::Mat k, distortion;
  std::vector<cv::Mat> rotations, translations;
  const double rms = cv::calibrateCamera(
      points, pixels, cv::Size(960, 720), k, distortion, rotations, translations);
  EXPECT_NEAR(ours.rms_px, rms, 0.002);
  EXPECT_NEAR(ours.camera.fx, k.at<double>(0, 0), 0.1);
  EXPECT_NEAR(ours.camera.cy, k.at<double>(1, 2), 0.1);
  EXPECT_NEAR(ours.camera.distortion[0], distortion.at<double>(0), 1e-3);
  EXPECT_LT(std::abs(ours.camera.fx - truth.fx), 4 * ours.sigma[0]);
  EXPECT_GT(ours.sigma[0], 0.005);
  EXPECT_LT(ours.sigma[0], 2);
}

CalibrationView SeenBy(const Camera& camera, int i) {
  return {See(camera, SomePose(i), 0.05, 7 + i), 0};
}

TEST(CalibratorTest, FindsAnUnknownCamera) {
  for (const CameraModel model : {CameraModel::kBrownConrady, CameraModel::kKannalaBrandt}) {
    const Camera truth = SomeCamera(model);
    CalibratorOptions options;
    options.model = model;
    Calibrator calibrator(960, 720, options);
    for (int i = 0; i < 40; ++i) calibrator.Add(SeenBy(truth, i));
    const Calibration c = calibrator.Solve();
    EXPECT_EQ(c.problem, "") << ToString(model);
    EXPECT_NEAR(c.camera.fx, truth.fx, 0.003 * truth.fx);
    EXPECT_NEAR(c.camera.cx, truth.cx, 1);
    EXPECT_LT(c.rms_px, 0.1);
    EXPECT_GT(c.coverage, 0.5);
  }
}

TEST(CalibratorTest, SaysWhatIsMissing) {
  const Camera truth = SomeCamera();
  Calibrator few(960, 720);
  EXPECT_TRUE(few.Add(SeenBy(truth, 0)));
  EXPECT_FALSE(few.Add(SeenBy(truth, 0))) << "the same view twice";
  EXPECT_NE(few.Solve().problem.find("different views"), std::string::npos);

  CalibratorOptions options;
  options.min_difference = 0.001;
  Calibrator straight(960, 720, options);
  for (int i = 0; i < 12; ++i) {
    // Straight from above: focal length and distance cannot be told apart.
    const Rigid3d pose = LookAt({0.001, 0.012 * i - 0.06, 0.5}, {0, 0.012 * i - 0.06, 0});
    straight.Add({See(truth, pose, 0.3, i), 0});
  }
  EXPECT_NE(straight.Solve().problem, "");
  EXPECT_FALSE(straight.Add({{}, 0}));

  Calibrator blurred(960, 720);
  CalibrationView view = SeenBy(truth, 1);
  view.blur_px = 20;
  EXPECT_FALSE(blurred.Add(view));
  CalibratorOptions bad;
  bad.distortion_terms = 3;
  EXPECT_THROW(Calibrator(960, 720, bad), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
