#include "livemvs/io/tum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "livemvs/io/dataset_test_scene.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace fs = std::filesystem;

TEST(TumTest, SequenceReadsAsTheSameCameras) {
  const TestScene scene = MakeTestScene(BrownConradyCamera());
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder / "rgb");
  WriteText(folder / "camera.yaml", OpenCvYaml(scene.camera));
  std::string rgb = "# timestamp filename\n", poses = "# timestamp tx ty tz qx qy qz qw\n";
  for (std::size_t v = 0; v < scene.size(); ++v) {
    const double time = 1305031102.25 + 0.03125 * static_cast<double>(v);
    rgb += Exact(time) + " rgb/v" + std::to_string(v) + ".pgm\n";
    poses += TumRow(time + 0.0003, scene.cam_from_world[v]);  // the same time, for practice
  }
  WriteText(folder / "rgb.txt", rgb);
  WriteText(folder / "groundtruth.txt", poses);
  const std::unique_ptr<Dataset> dataset = Open(folder);
  EXPECT_NEAR(dataset->views()[1].timestamp - dataset->views()[0].timestamp, 0.03125, 1e-6);
  ExpectScene(*dataset, scene, kTolerance);
}

TEST(TrajectoryTest, InterpolatesBetweenNeighboursAndNotAcrossGaps) {
  // A turn about z at constant rate while moving along x: known at all times.
  const auto world_from_cam = [](double t) {
    Rigid3d pose;
    pose.rotation << std::cos(t), -std::sin(t), 0, std::sin(t), std::cos(t), 0, 0, 0, 1;
    pose.translation = {2 * t, 0, 1};
    return pose;
  };
  std::vector<double> times = {0, 0.05, 0.15, 0.6};
  std::vector<Rigid3d> poses;
  for (const double t : times) poses.push_back(world_from_cam(t));
  const Trajectory trajectory(times, poses);
  for (const double t : {0.0, 0.01, 0.05, 0.1, 0.149, 0.15, 0.6}) {
    const std::optional<Rigid3d> pose = trajectory.At(t);
    ASSERT_TRUE(pose.has_value()) << t;
    const Rigid3d expected = world_from_cam(t).Inverse();
    EXPECT_LT((pose->rotation - expected.rotation).norm(), 1e-9) << t;
    EXPECT_LT((pose->translation - expected.translation).norm(), 1e-9) << t;
  }
  EXPECT_TRUE(trajectory.At(-0.0004).has_value());
  for (const double t : {-0.001, 0.16, 0.3, 0.59, 0.601, 1e9, -1e9}) {
    EXPECT_FALSE(trajectory.At(t).has_value()) << t;
  }
}

class BrokenTumTest : public ::testing::Test {
 protected:
  fs::path Sequence(const std::string& rgb, const std::string& poses) const {
    const fs::path folder = FreshFolder("data");
    WriteSceneImages(scene_, folder / "rgb");
    WriteText(folder / "camera.yaml", OpenCvYaml(scene_.camera));
    WriteText(folder / "rgb.txt", rgb);
    WriteText(folder / "groundtruth.txt", poses);
    return folder;
  }

  TestScene scene_ = MakeTestScene(PinholeCamera());
  std::string rgb_ = "0 rgb/v0.pgm\n0.1 rgb/v1.pgm\n0.2 rgb/v2.pgm\n9 rgb/v3.pgm\n";
  std::string poses_ = TumRow(0, scene_.cam_from_world[0]) + TumRow(0.1, scene_.cam_from_world[1]) +
                       TumRow(0.2, scene_.cam_from_world[2]);
};

TEST_F(BrokenTumTest, ImagesOutsideOfTheTrajectoryAreLeftOutAndCounted) {
  LogCatcher log;
  const std::unique_ptr<Dataset> dataset = Open(Sequence(rgb_, poses_));
  EXPECT_THAT(dataset->views(), SizeIs(3));
  EXPECT_EQ(dataset->statistics().skipped, 1);
  ASSERT_THAT(log.warnings(), SizeIs(1));
  EXPECT_THAT(log.warnings()[0], HasSubstr("1 images lie outside of the trajectory"));
}

TEST_F(BrokenTumTest, ErrorsNameFileLineAndReason) {
  EXPECT_THAT(OpenError(Sequence(rgb_, poses_ + "0.2 0 0 0 0 0 0 1\n")),
              ::testing::AllOf(HasSubstr("groundtruth.txt:4"), HasSubstr("is not after")));
  EXPECT_THAT(OpenError(Sequence("1 rgb/v0.pgm\n0 rgb/v1.pgm\n", poses_)), HasSubstr("rgb.txt:2"));
  EXPECT_THAT(OpenError(Sequence(rgb_, poses_ + "1 0 0 nan 0 0 0 1\n")), HasSubstr("'nan'"));
  EXPECT_THAT(OpenError(Sequence(rgb_, poses_ + "1 0 0 0 0 0 0 0\n")), HasSubstr("norm is 0"));
  EXPECT_THAT(OpenError(Sequence(rgb_, poses_ + "1 0 0 0 0 0 1\n")), HasSubstr("7 words"));
  EXPECT_THAT(OpenError(Sequence(rgb_, "# none\n")), HasSubstr("holds no pose"));
  EXPECT_THAT(OpenError(Sequence("0 ../x.pgm\n0.1 rgb/v1.pgm\n", poses_)), HasSubstr("leaves"));
  EXPECT_THAT(OpenError(Sequence("100 rgb/v0.pgm\n101 rgb/v1.pgm\n", poses_)),
              HasSubstr("no frame"));
  const fs::path folder = Sequence(rgb_, poses_);
  fs::remove(folder / "camera.yaml");
  EXPECT_THAT(OpenError(folder), HasSubstr("--camera"));
  fs::remove(folder / "groundtruth.txt");
  EXPECT_THAT(OpenError(folder), HasSubstr("groundtruth.txt"));
}

TEST(TrajectoryTest, WhatIsWrittenReadsAsTheSamePoses) {
  const TestScene scene = MakeTestScene(BrownConradyCamera());
  const fs::path file = FreshFolder("data") / "poses.txt";
  std::vector<StampedPose> poses;
  for (std::size_t v = 0; v < scene.size(); ++v) {
    poses.push_back({0.04 * static_cast<double>(v), scene.cam_from_world[v]});
  }
  WriteTumTrajectory(file, poses, "a test");
  const Trajectory back = ReadTumTrajectory(file, PoseConvention::kAuto);
  ASSERT_EQ(back.size(), poses.size());
  constexpr double kDigits = 1e-7;  // of nine
  for (const StampedPose& pose : poses) {
    const auto read = back.At(pose.time);
    ASSERT_TRUE(read);
    EXPECT_LT((read->rotation - pose.cam_from_world.rotation).norm(), kDigits);
    EXPECT_LT((read->translation - pose.cam_from_world.translation).norm(), kDigits);
  }
}

}  // namespace
}  // namespace livemvs
