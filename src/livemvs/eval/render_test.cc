#include "livemvs/eval/render.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "livemvs/eval/color_ramp.h"
#include "livemvs/eval/plot.h"
#include "livemvs/eval/split_mix.h"
#include "livemvs/eval/stroke_font.h"

namespace livemvs {
namespace {

/// Points on a flat square of side 2 about the origin, seen from +z, with a colour.
PointCloud SquareCloud(float z, Rgb color, int n = 80) {
  PointCloud cloud;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      Point p;
      p.position = {2 * static_cast<float>(x) / static_cast<float>(n - 1) - 1,
                    2 * static_cast<float>(y) / static_cast<float>(n - 1) - 1,
                    z};
      p.normal = {0, 0, 1};
      p.color = color;
      cloud.push_back(p);
    }
  }
  return cloud;
}

ViewOptions FromAbove() {
  ViewOptions options;
  options.width = 200;
  options.height = 160;
  options.direction = Eigen::Vector3d(0, 0, 1);
  options.up = Eigen::Vector3d(0, 1, 0);
  return options;
}

CloudRenderOptions Plain() {
  CloudRenderOptions options;
  options.scale_bar = false;
  return options;
}

/// Points in a block, one far out and one that is no number.
PointCloud BlockWithOutliers() {
  SplitMix64 random(1);
  PointCloud cloud(2000);
  for (Point& p : cloud) {
    const double x = random.Uniform(), y = random.Uniform(), z = random.Uniform();
    p.position = Eigen::Vector3d(5 + x, 3 * y, 0.2 * z).cast<float>();
    p.normal = {0.5f, -0.7f, 0.5f};
  }
  cloud[0].position = {1000, 0, 0};
  cloud[1].position.x() = std::numeric_limits<float>::quiet_NaN();
  return cloud;
}

TEST(FitView, PointsFillThePicture) {
  const PointCloud cloud = BlockWithOutliers();
  for (double turn : {0.0, 60.0, 200.0}) {
    ViewOptions options;
    options.turn_deg = turn;
    const RenderView view = FitView(cloud, MeanViewingDirection(cloud), options);
    const Eigen::Matrix3d& rotation = view.cam_from_world.rotation;
    EXPECT_NEAR((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(rotation.determinant(), 1, 1e-12);
    const Projector projector(view.camera);
    Eigen::Vector2d lo(1e9, 1e9), hi(-1e9, -1e9);
    int outside = 0;
    for (std::size_t i = 2; i < cloud.size(); ++i) {
      const auto pixel = projector.Project(view.cam_from_world * cloud[i].position.cast<double>());
      ASSERT_TRUE(pixel);
      outside += !view.camera.Contains(*pixel);
      lo = lo.cwiseMin(*pixel);
      hi = hi.cwiseMax(*pixel);
    }
    EXPECT_LE(outside, 5);
    const Eigen::Vector2d filled = (hi - lo).array() / Eigen::Array2d(1280, 960);
    EXPECT_GT(filled.maxCoeff(), 0.8);
  }
}

TEST(FitView, UpIsUpAndDirectionsHold) {
  const PointCloud cloud = SquareCloud(0, {255, 0, 0});
  ViewOptions options;
  options.up = Eigen::Vector3d(0, 0, 1);
  options.direction = Eigen::Vector3d(0, -1, 0.5);
  RenderView view = FitView(cloud, Eigen::Vector3d::Zero(), options);
  const Projector projector(view.camera);
  const auto low = projector.Project(view.cam_from_world * Eigen::Vector3d(0, 0, 0));
  const auto high = projector.Project(view.cam_from_world * Eigen::Vector3d(0, 0, 0.5));
  const auto right = projector.Project(view.cam_from_world * Eigen::Vector3d(0.5, 0, 0));
  EXPECT_LT(high->y(), low->y());
  EXPECT_NEAR(high->x(), low->x(), 0.5);  // but for perspective
  EXPECT_GT(right->x(), low->x());
  options.level = true;
  view = FitView(cloud, Eigen::Vector3d::Zero(), options);
  EXPECT_NEAR(view.cam_from_world.Center().normalized().z(), 0, 0.02);
  options.level = false;
  options.from_above = true;
  view = FitView(cloud, Eigen::Vector3d::Zero(), options);
  EXPECT_GT(view.cam_from_world.Center().normalized().z(), 0.99);
}

TEST(FitView, DegenerateCloudsAndWrongOptions) {
  const Point p;
  for (const PointCloud& cloud : {PointCloud{}, PointCloud{p}, PointCloud(10, p)}) {
    const RenderView view = FitView(cloud, MeanViewingDirection(cloud), FromAbove());
    EXPECT_TRUE(view.cam_from_world.translation.allFinite());
    EXPECT_GT(view.focus_depth, 0);
    const RgbImage image = CloudRenderer(cloud, CloudRenderOptions{}).Draw(view);
    EXPECT_EQ(image.width(), 200);
  }
  ViewOptions options;
  options.width = 0;
  EXPECT_THROW(options.Check(), std::invalid_argument);
  options = {};
  options.up = Eigen::Vector3d::Zero();
  EXPECT_THROW(options.Check(), std::invalid_argument);
}

TEST(GuessUp, LevelPlanesSeenFromAboveDecide) {
  PointCloud table = SquareCloud(0, {0, 0, 0});
  EXPECT_EQ(GuessUp(table, {0.5, 0.5, 0.7}), Eigen::Vector3d(0, 0, 1));
  for (Point& p : table) p.normal = {0, -1, 0};
  EXPECT_EQ(GuessUp(table, {0.1, -0.4, -0.8}), Eigen::Vector3d(0, -1, 0));
}

TEST(UpOfCameras, IsTheAxisOfAnOrbitAndTheImagesTopOtherwise) {
  // Cameras on a quarter of a circle, 40 degrees above it, looking at its middle.
  std::vector<Rigid3d> orbit;
  for (double angle = 0; angle < 1.6; angle += 0.1) {
    ViewOptions options = FromAbove();
    options.up = Eigen::Vector3d(0, 0, 1);
    options.direction = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.84);
    orbit.push_back(FitView({}, Eigen::Vector3d::Zero(), options).cam_from_world);
  }
  EXPECT_GT(UpOfCameras(orbit).z(), std::cos(3 * M_PI / 180));
  EXPECT_NEAR(UpOfCameras(orbit).norm(), 1, 1e-12);
  EXPECT_NEAR((UpOfCameras({Rigid3d{}}) - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-9);
  EXPECT_TRUE(UpOfCameras({}).isZero());
}

TEST(CloudRenderer, ClosesTheSurfaceInItsColor) {
  const PointCloud cloud = SquareCloud(0, {200, 40, 40});
  const RgbImage image = CloudRenderer(cloud, Plain()).Draw(FitView(cloud, {0, 0, 1}, FromAbove()));
  for (int y = 50; y < 110; ++y) {
    for (int x = 70; x < 130; ++x) {
      const Rgb& c = image(x, y);
      ASSERT_GT(c[0], 150) << x << " " << y;
      ASSERT_LT(c[1], 90) << x << " " << y;
    }
  }
  EXPECT_GT(image(2, 2)[1], 200);  // background
}

TEST(CloudRenderer, WhatIsNearerHides) {
  PointCloud cloud = SquareCloud(0, {200, 40, 40});
  const PointCloud front = SquareCloud(0.5f, {40, 40, 200});
  const PointCloud behind = SquareCloud(-0.5f, {40, 200, 40});
  cloud.insert(cloud.begin(), front.begin(), front.end());
  cloud.insert(cloud.end(), behind.begin(), behind.end());
  const RenderView view = FitView(cloud, {0, 0, 1}, FromAbove());
  const RgbImage image = CloudRenderer(cloud, Plain()).Draw(view);
  const Rgb& middle = image(100, 80);
  EXPECT_GT(middle[2], 150);
  EXPECT_LT(middle[0], 90);
}

TEST(CloudRenderer, WhatIsNotKnownIsGrey) {
  PointCloud cloud = SquareCloud(0, {200, 40, 40});
  for (const float sigma : {std::numeric_limits<float>::quiet_NaN(), 0.0F}) {
    for (Point& p : cloud) p.sigma = p.position.x() < 0 ? sigma : 0.001F + 0.1F * p.position.x();
    CloudRenderOptions options = Plain();
    options.color = RenderColor::kSigma;
    const RgbImage image =
        CloudRenderer(cloud, options).Draw(FitView(cloud, {0, 0, 1}, FromAbove()));
    const auto spread = [](const Rgb& c) { return std::ranges::max(c) - std::ranges::min(c); };
    EXPECT_LE(spread(image(80, 80)), 8) << sigma;
    EXPECT_GT(image(80, 80)[0], 60) << sigma;
    EXPECT_GT(spread(image(120, 80)), 40) << sigma;
  }
}

TEST(CloudRenderer, IsDeterministicAndTakesAllColors) {
  PointCloud cloud = SquareCloud(0, {90, 90, 90}, 30);
  SplitMix64 random(9);
  for (Point& p : cloud) {
    p.position.z() = static_cast<float>(0.3 * random.Uniform());
    p.sigma = static_cast<float>(random.Uniform());
    p.inlier_ratio = static_cast<float>(random.Uniform());
  }
  cloud[7].sigma = std::numeric_limits<float>::quiet_NaN();
  cloud[8].position.x() = std::numeric_limits<float>::quiet_NaN();
  cloud[9].normal.x() = std::numeric_limits<float>::infinity();
  const RenderView view = FitView(cloud, {0, 0, 1}, FromAbove());
  for (RenderColor color : {RenderColor::kRgb,
                            RenderColor::kNormal,
                            RenderColor::kSigma,
                            RenderColor::kInlierRatio,
                            RenderColor::kHeight}) {
    CloudRenderOptions options;
    options.color = color;
    options.unit = "m";
    const RgbImage a = CloudRenderer(cloud, options).Draw(view);
    const RgbImage b = CloudRenderer(cloud, options).Draw(view);
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) ASSERT_EQ(a(x, y), b(x, y));
    }
  }
}

TEST(RenderMesh, DrawsItsColorsWhereItIs) {
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.colors.assign(4, Rgb{40, 200, 40});
  const PointCloud fit = SquareCloud(0, {0, 0, 0});
  const RenderView view = FitView(fit, {0, 0, 1}, FromAbove());
  const std::vector<Eigen::Vector3f> white(4, Eigen::Vector3f::Ones());
  const FragmentImage fragments = DrawMesh(mesh, white, view, 1);
  EXPECT_NEAR(fragments.At(100, 80).depth, view.focus_depth, 1e-3);
  EXPECT_TRUE(std::isinf(fragments.At(1, 1).depth));
  const RgbImage image = RenderMesh(mesh, view, Plain());
  EXPECT_GT(image(100, 80)[1], 150);
  EXPECT_LT(image(100, 80)[0], 90);
  EXPECT_GT(image(1, 1)[0], 180);
}

TEST(Canvas, LineCoversItsWidthAndKeepsToThePicture) {
  RgbImage image = MakeRgbImage(40, 20, {255, 255, 255});
  Canvas canvas(image);
  canvas.Line({-50, 10}, {500, 10}, 3, {0, 0, 0});
  for (int x = 0; x < 40; ++x) {
    for (int y = 9; y <= 11; ++y) ASSERT_EQ(image(x, y)[0], 0);
    ASSERT_EQ(image(x, 7)[0], 255);
    ASSERT_EQ(image(x, 13)[0], 255);
  }
  canvas.Line({std::nan(""), 0}, {1, 1}, 1, {0, 0, 0});
  canvas.Text({35, 15}, "cut off \t", 12, {0, 0, 0});
  canvas.Fill(-5, -5, 100, 100, {1, 2, 3});
  EXPECT_EQ(image(39, 19), (Rgb{1, 2, 3}));
}

TEST(StrokeFont, EveryCharacterIsDrawnAndDiffers) {
  for (int c = '!'; c <= '~'; ++c) {
    const Glyph glyph = GlyphOf(static_cast<char>(c));
    ASSERT_FALSE(glyph.strokes.empty());
    for (const auto& stroke : glyph.strokes) {
      ASSERT_GE(stroke.size(), 2u) << static_cast<char>(c);
      for (const Eigen::Vector2d& p : stroke) {
        ASSERT_TRUE(p.x() >= 0 && p.x() <= 4 && p.y() >= -2 && p.y() <= 7) << static_cast<char>(c);
      }
    }
    for (int d = '!'; d < c; ++d) {
      ASSERT_NE(GlyphOf(static_cast<char>(d)).strokes, glyph.strokes)
          << static_cast<char>(d) << " " << static_cast<char>(c);
    }
  }
  EXPECT_EQ(Canvas::TextWidth("", 12), 0);
  EXPECT_GT(Canvas::TextWidth("mm", 12), Canvas::TextWidth("i", 12));
}

TEST(CurvePlot, RoundNumbersAndWrongAxes) {
  EXPECT_EQ(RoundNumbers(0.5, 20).size(), 6u);  // 0.5 1 2 5 10 20
  EXPECT_TRUE(RoundNumbers(0, 1).empty());
  EXPECT_EQ(ShortNumber(0.25), "0.25");
  CurvePlot plot;
  plot.x_min = 0;
  EXPECT_THROW(plot.Draw(), std::invalid_argument);
}

TEST(ColorRamp, SrgbRoundTrips) {
  for (int v = 0; v < 256; ++v) {
    const auto c = static_cast<std::uint8_t>(v);
    const Rgb color = {c, c, c};
    ASSERT_EQ(SrgbFromLinear(LinearFromSrgb(color)), color);
  }
  EXPECT_EQ(RampColor(-1), RampColor(0));
  EXPECT_EQ(RampColor(2), RampColor(1));
  EXPECT_EQ(RampColor(std::numeric_limits<double>::quiet_NaN()), RampColor(0));
}

}  // namespace
}  // namespace livemvs
