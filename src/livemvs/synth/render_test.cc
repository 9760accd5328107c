#include "livemvs/synth/render.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "livemvs/synth/camera_path.h"
#include "livemvs/synth/sequence.h"

namespace livemvs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const SyntheticScene& Plane() {
  static const SyntheticScene scene({.name = "plane"});
  return scene;
}

const SyntheticScene& Table() {
  static const SyntheticScene scene({.name = "table"});
  return scene;
}

Camera Distorted(CameraModel model) {
  Camera camera = SyntheticCamera(160, 120);
  camera.model = model;
  if (model == CameraModel::kBrownConrady) camera.distortion = {-0.2, 0.05, 0.002, -0.001};
  if (model == CameraModel::kKannalaBrandt) camera.distortion = {0.03, -0.01};
  return camera;
}

bool SamePixels(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int y = 0; y < a.height(); ++y) {
    if (std::memcmp(a.Row(y), b.Row(y), static_cast<std::size_t>(a.width())) != 0) return false;
  }
  return true;
}

class RenderWithModel : public testing::TestWithParam<CameraModel> {};

TEST_P(RenderWithModel, DepthOfASlantedPlaneIsExact) {
  const Camera camera = Distorted(GetParam());
  const Projector projector(camera);
  const Rigid3d pose = LookAt({0.3, -0.2, 0.6}, {0.05, 0.02, 0});
  const RenderedFrame frame = RenderFrame(Plane(), camera, pose);
  for (int y = 0; y < camera.height; y += 7) {
    for (int x = 0; x < camera.width; x += 7) {
      // World z of center + depth * R' ray is 0.
      const Vector3d ray = *projector.Unproject(Vector2d(x, y));
      const double slope = (pose.rotation.transpose() * ray).z();
      EXPECT_NEAR(frame.z_depth(x, y), -pose.Center().z() / slope, 1e-6);
      // Back through the lens, the point falls on its pixel.
      const auto back = projector.Project(static_cast<double>(frame.z_depth(x, y)) * ray);
      ASSERT_TRUE(back);
      EXPECT_LT((*back - Vector2d(x, y)).norm(), 1e-5);
    }
  }
}

TEST_P(RenderWithModel, APointLooksTheSameFromTwoViews) {
  const Camera camera = Distorted(GetParam());
  const Projector projector(camera);
  const Rigid3d a = LookAt({0.3, -0.45, 0.4}, {0, 0, 0.03}),
                b = LookAt({0.25, -0.48, 0.42}, {0, 0, 0.03});
  const FrameRenderOptions options{.samples_per_pixel = 9};
  const RenderedFrame first = RenderFrame(Table(), camera, a, options);
  const RenderedFrame second = RenderFrame(Table(), camera, b, options);
  int compared = 0, same_material = 0, same_grey = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (first.z_depth(x, y) == 0) continue;
      const Vector3d in_a = first.z_depth(x, y) * *projector.Unproject(Vector2d(x, y));
      const Vector3d in_b = b * (a.Inverse() * in_a);
      const auto pixel = projector.Project(in_b);
      if (!pixel || !camera.Contains(*pixel, 1)) continue;
      const int u = static_cast<int>(std::lround(pixel->x()));
      const int v = static_cast<int>(std::lround(pixel->y()));
      if (std::abs(second.z_depth(u, v) - in_b.z()) > 0.01 * in_b.z()) continue;  // hidden
      ++compared;
      same_material += first.material(x, y) == second.material(u, v);
      // Half a pixel off: what is left is the texture's slope.
      same_grey += std::abs(first.picture.grey(x, y) - second.picture.grey(u, v)) < 25;
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_GT(same_material, 0.97 * compared);
  EXPECT_GT(same_grey, 0.85 * compared);
}

INSTANTIATE_TEST_SUITE_P(Models,
                         RenderWithModel,
                         testing::Values(CameraModel::kPinhole,
                                         CameraModel::kBrownConrady,
                                         CameraModel::kKannalaBrandt));

TEST(Render, BytesDoNotDependOnTheNumberOfThreads) {
  const Camera camera = SyntheticCamera(160, 120);
  const Rigid3d pose = MakePath(DefaultPath("table"))[7];
  const FrameRenderOptions options{.noise_sigma = 2};
  const RenderedFrame many = RenderFrame(Table(), camera, pose, options, 7);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const SyntheticScene again({.name = "table"});
  const RenderedFrame few = RenderFrame(again, camera, pose, options, 7);
  EXPECT_TRUE(SamePixels(many.picture.grey, few.picture.grey));
  EXPECT_TRUE(SamePixels(many.picture.cb, few.picture.cb));
  EXPECT_TRUE(SamePixels(many.picture.cr, few.picture.cr));
  EXPECT_TRUE(SamePixels(many.material, few.material));
  for (int y = 0; y < camera.height; ++y) {
    EXPECT_EQ(0, std::memcmp(many.z_depth.Row(y), few.z_depth.Row(y), 4 * 160)) << y;
  }
}

TEST(Render, NoiseHasItsSigmaAndDiffersBetweenFrames) {
  const Camera camera = SyntheticCamera(200, 200);
  const Rigid3d pose = LookAt({0, -0.1, 0.6}, {0, 0, 0});
  const RenderedFrame clean = RenderFrame(Plane(), camera, pose);
  const FrameRenderOptions options{.noise_sigma = 3};
  const RenderedFrame a = RenderFrame(Plane(), camera, pose, options, 1);
  const RenderedFrame b = RenderFrame(Plane(), camera, pose, options, 2);
  double sum = 0, squares = 0, product = 0, neighbours = 0;
  int n = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 1; x < 200; ++x) {
      const double da = a.picture.grey(x, y) - clean.picture.grey(x, y);
      const double db = b.picture.grey(x, y) - clean.picture.grey(x, y);
      sum += da;
      squares += da * da;
      product += da * db;
      neighbours += da * (a.picture.grey(x - 1, y) - clean.picture.grey(x - 1, y));
      ++n;
    }
  }
  // Rounding twice adds 1/6 to the variance; 40 000 samples leave 1 % of chance.
  EXPECT_NEAR(sum / n, 0, 0.06);
  EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(9 + 1.0 / 6), 0.1);
  EXPECT_NEAR(product / squares, 0, 0.03);
  EXPECT_NEAR(neighbours / squares, 0, 0.03);
}

TEST(Render, BlurIsTheMeanOverTheShutter) {
  const Camera camera = SyntheticCamera(120, 90);
  const Rigid3d a = LookAt({0.00, -0.1, 0.6}, {0.00, 0, 0});
  const Rigid3d b = LookAt({0.02, -0.1, 0.6}, {0.02, 0, 0});
  const auto contrast = [&](const RenderedFrame& frame) {
    double sum = 0;
    for (int y = 0; y < 90; ++y) {
      for (int x = 1; x < 120; ++x) {
        sum += std::abs(frame.picture.grey(x, y) - frame.picture.grey(x - 1, y));
      }
    }
    return sum;
  };
  FrameRenderOptions blurred{.samples_per_pixel = 16};
  for (int i = 0; i < 16; ++i) {
    Rigid3d pose = a;
    pose.translation += (i + 0.5) / 16 * (b.translation - a.translation);
    blurred.shutter_poses.push_back(pose);
  }
  const RenderedFrame sharp = RenderFrame(Plane(), camera, a, {.samples_per_pixel = 16});
  const RenderedFrame soft = RenderFrame(Plane(), camera, a, blurred);
  EXPECT_LT(contrast(soft), 0.7 * contrast(sharp));
  EXPECT_EQ(soft.z_depth(60, 45), sharp.z_depth(60, 45));
}

TEST(Render, RejectsNonsense) {
  const Camera camera = SyntheticCamera(16, 16);
  EXPECT_THROW(RenderFrame(Plane(), camera, {}, {.samples_per_pixel = 0}), std::invalid_argument);
  EXPECT_THROW(RenderFrame(Plane(), camera, {}, {.noise_sigma = NAN}), std::invalid_argument);
  EXPECT_THROW(RenderFrame(Plane(), Camera{}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
