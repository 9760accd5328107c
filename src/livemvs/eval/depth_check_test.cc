#include "livemvs/eval/depth_check.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr double kDepth = 1.5;

DepthView View() {
  DepthView view;
  view.camera.width = 64;
  view.camera.height = 48;
  view.camera.fx = view.camera.fy = 50;
  view.camera.cx = 31.5;
  view.camera.cy = 23.5;
  view.cam_from_world.translation = {0.1, -0.2, 0.3};
  return view;
}

/// A wall at 1.5 m; the left eight columns were not measured.
Image<std::uint16_t> Wall() {
  Image<std::uint16_t> depth(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      depth(x, y) = static_cast<std::uint16_t>(x < 4 ? 0 : x < 8 ? 65535 : 1500);
    }
  }
  return depth;
}

/// The point that the view sees at a pixel at the given depth.
Point Seen(double x, double y, double z) {
  const DepthView view = View();
  const Eigen::Vector3d in_cam(
      (x - view.camera.cx) / view.camera.fx * z, (y - view.camera.cy) / view.camera.fy * z, z);
  Point p;
  p.position = (view.cam_from_world.Inverse() * in_cam).cast<float>();
  return p;
}

DepthCheckResult Compare(const PointCloud& cloud, const Image<std::uint16_t>& depth) {
  DepthCheckResult result;
  CompareWithDepth(cloud, View(), depth, DepthCheckOptions{}, &result);
  return result;
}

TEST(DepthCheck, CountsAgreeingFloatingAndHiddenPoints) {
  const PointCloud cloud = {Seen(30, 20, kDepth + 0.01),  // agree
                            Seen(31, 20, kDepth - 0.03),
                            Seen(32, 20, kDepth + 0.05),
                            Seen(33, 20, kDepth - 0.2),  // floats
                            Seen(34, 20, kDepth + 0.2),  // hidden
                            Seen(5, 20, kDepth),         // nothing measured there
                            Seen(1, 20, kDepth),         // too near the edge
                            Seen(30, 20, 0.2),           // too near the camera
                            Seen(30, 20, 3.5)};          // too far
  const DepthCheckResult result = Compare(cloud, Wall());
  EXPECT_EQ(result.points, 9);
  EXPECT_EQ(result.frames, 1);
  EXPECT_EQ(result.agree, 3);
  EXPECT_EQ(result.floating, 1);
  EXPECT_EQ(result.behind, 1);
  EXPECT_NEAR(result.MedianError(), 0.03, 1e-5);
  EXPECT_NEAR(result.FloatingShare(), 0.25, 1e-12);
}

TEST(DepthCheck, TakesTheBestOfNineMeasurements) {
  Image<std::uint16_t> depth = Wall();
  depth(41, 31) = 900;  // diagonal neighbour of (40, 30)
  const DepthCheckResult near = Compare({Seen(40, 30, 0.9)}, depth);
  EXPECT_EQ(near.agree, 1);
  EXPECT_NEAR(near.MedianError(), 0, 1e-5);
  const DepthCheckResult two_off = Compare({Seen(39, 30, 0.9)}, depth);
  EXPECT_EQ(two_off.floating, 1);
}

TEST(DepthCheck, EmptyAndBrokenPoints) {
  Point broken;
  broken.position.z() = std::numeric_limits<float>::quiet_NaN();
  const DepthCheckResult result = Compare({broken}, Wall());
  EXPECT_EQ(result.points, 0);
  EXPECT_EQ(result.MedianError(), 0);
  EXPECT_EQ(result.FloatingShare(), 0);
  EXPECT_THROW(Compare({}, Image<std::uint16_t>(10, 10)), std::invalid_argument);
}

/// Writes a list of depth pictures and returns its path.
std::string WriteList(const std::string& text) {
  const std::string path = testing::TempDir() + "/cams_depth_test.txt";
  std::ofstream(path) << text;
  return path;
}

TEST(ReadDepthViews, ReadsNamesCamerasAndPoses) {
  const auto views = ReadDepthViews(
      WriteList("# comment\n\na.png 64 48 50 51 31 23 0 0 0 0 1 0 0 0 1 0 0 0 1 1 2 3\r\n"
                "b.png 64 48 50 51 31 23 0.1 0 0 0 0 -1 0 1 0 0 0 0 1 1 2 3\n"));
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0].name, "a.png");
  EXPECT_EQ(views[0].camera.height, 48);
  EXPECT_EQ(views[0].camera.fy, 51);
  EXPECT_EQ(views[0].camera.model, CameraModel::kPinhole);
  EXPECT_EQ(views[0].cam_from_world.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(views[1].camera.model, CameraModel::kBrownConrady);
  EXPECT_EQ(views[1].cam_from_world.rotation(0, 1), -1);
}

TEST(ReadDepthViews, RejectsBrokenFiles) {
  EXPECT_THROW(ReadDepthViews(testing::TempDir() + "/missing/cams_depth.txt"), Error);
  const std::string pose = " 0 0 0 0 1 0 0 0 1 0 0 0 1 1 2 3\n";
  const std::string not_a_rotation = " 0 0 0 0 2 0 0 0 1 0 0 0 1 1 2 3\n";
  for (const std::string& list : {std::string(),
                                  std::string("# only a comment\n"),
                                  std::string("a.png 64 48 50 51 31 23 0 0 0\n"),
                                  "a.png 64 48 nan 51 31 23" + pose,
                                  "a.png 64 48 0 51 31 23" + pose,
                                  "a.png 1e9 48 50 51 31 23" + pose,
                                  "a.png 64 48 50 51 31 23" + not_a_rotation}) {
    EXPECT_THROW(ReadDepthViews(WriteList(list)), Error) << list;
  }
}

}  // namespace
}  // namespace livemvs
