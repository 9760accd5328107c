#include "livemvs/io/dataset_consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

namespace livemvs {
namespace {

constexpr int kSlopeFrames = 10;

Camera TestCamera() {
  Camera camera;
  camera.width = 240;
  camera.height = 180;
  camera.fx = 260;
  camera.fy = 255;
  camera.cx = 118;
  camera.cy = 92;
  return camera;
}

// Random grey levels on a grid of unit cells, interpolated.
double Texture(double x, double y) {
  const auto level = [](int i, int j) {
    unsigned h = static_cast<unsigned>(i) * 374761393u + static_cast<unsigned>(j) * 668265263u;
    h = (h ^ (h >> 13)) * 1274126177u;
    return static_cast<double>((h ^ (h >> 16)) & 255u);
  };
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double u = x - i, v = y - j;
  return (1 - v) * ((1 - u) * level(i, j) + u * level(i + 1, j)) +
         v * ((1 - u) * level(i, j + 1) + u * level(i + 1, j + 1));
}

// A textured slope, z = 1 + x / 2, seen from a camera that moves and turns.
std::vector<PosedFrame> RenderFrames() {
  std::vector<PosedFrame> frames;
  const Eigen::Vector3d normal(-0.5, 0, 1);
  for (int f = 0; f < kSlopeFrames; ++f) {
    PosedFrame frame;
    frame.index = f;
    frame.camera = TestCamera();
    Rigid3d world_from_cam;
    world_from_cam.rotation =
        (Eigen::AngleAxisd(0.02 * f - 0.3, Eigen::Vector3d(0.3, 1, 0.2).normalized()))
            .toRotationMatrix();
    world_from_cam.translation = Eigen::Vector3d(0.2 - 0.012 * f, 0.008 * f, 0.1 + 0.004 * f);
    frame.cam_from_world = world_from_cam.Inverse();
    auto picture = std::make_shared<Picture>();
    picture->grey = Image<std::uint8_t>(frame.camera.width, frame.camera.height);
    for (int y = 0; y < frame.camera.height; ++y) {
      for (int x = 0; x < frame.camera.width; ++x) {
        const Eigen::Vector3d ray =
            world_from_cam.rotation * Eigen::Vector3d((x - frame.camera.cx) / frame.camera.fx,
                                                      (y - frame.camera.cy) / frame.camera.fy,
                                                      1);
        const double t = (1 - normal.dot(world_from_cam.translation)) / normal.dot(ray);
        const Eigen::Vector3d p = world_from_cam.translation + t * ray;
        picture->grey(x, y) = static_cast<std::uint8_t>(Texture(60 * p.x(), 60 * p.y()));
      }
    }
    frame.picture = picture;
    frames.push_back(std::move(frame));
  }
  return frames;
}

Rigid3d Flipped(Rigid3d pose) {
  pose.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal() * pose.rotation;
  pose.translation = Eigen::Vector3d(1, -1, -1).asDiagonal() * pose.translation;
  return pose;
}

TEST(DatasetConsistencyTest, RightPosesAgreeWithThePictures) {
  const EpipolarReport report = CheckEpipolarConsistency(RenderFrames());
  EXPECT_TRUE(report.conclusive());
  EXPECT_LT(report.median_error_px[0], 0.3);
  EXPECT_EQ(report.best, PoseReading::kAsIs);
  EXPECT_FALSE(report.suggests_other());
}

TEST(DatasetConsistencyTest, MisreadPosesAreFoundOut) {
  const std::vector<PosedFrame> frames = RenderFrames();
  for (const PoseReading reading : {PoseReading::kInverse, PoseReading::kFlippedAxes}) {
    std::vector<PosedFrame> misread = frames;
    for (PosedFrame& frame : misread) {
      frame.cam_from_world = reading == PoseReading::kInverse ? frame.cam_from_world.Inverse()
                                                              : Flipped(frame.cam_from_world);
    }
    const EpipolarReport report = CheckEpipolarConsistency(misread);
    EXPECT_TRUE(report.suggests_other());
    EXPECT_EQ(report.best, reading) << ToString(report.best);
  }
  // OpenGL's world_from_cam read as cam_from_world.
  std::vector<PosedFrame> misread = frames;
  for (PosedFrame& frame : misread) frame.cam_from_world = Flipped(frame.cam_from_world).Inverse();
  const EpipolarReport report = CheckEpipolarConsistency(misread);
  EXPECT_EQ(report.best, PoseReading::kInverseFlippedAxes);
  EXPECT_TRUE(report.suggests_other());
}

TEST(DatasetConsistencyTest, NothingIsSaidWithoutTexture) {
  std::vector<PosedFrame> frames = RenderFrames();
  for (PosedFrame& frame : frames) {
    auto blank = std::make_shared<Picture>();
    blank->grey = Image<std::uint8_t>(240, 180);
    frame.picture = blank;
  }
  EXPECT_FALSE(CheckEpipolarConsistency(frames).conclusive());
  EXPECT_FALSE(CheckEpipolarConsistency({}).conclusive());
}

}  // namespace
}  // namespace livemvs
