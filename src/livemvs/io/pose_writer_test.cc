#include "livemvs/io/pose_writer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "livemvs/core/error.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/colmap.h"
#include "livemvs/io/pose_file.h"
#include "livemvs/io/transforms.h"
#include "temporary.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using testing_support::Temporary;

constexpr double kExact = 1e-9;  // written with all digits; quaternions round

Rigid3d SomePose(double angle) {
  return {Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix(),
          {0.1 * angle, -0.2, 0.7}};
}

std::vector<TrackedPose> SomePoses() {
  return {{3, 0.1, "images/000003.png", SomePose(0.3)},
          {5, 0.16667, "images/000005.png", SomePose(-2.9)},
          {6, 0.2, "images/000006.png", SomePose(3.1)}};
}

Camera SomeCamera(CameraModel model) {
  Camera camera{.model = model,
                .width = 640,
                .height = 480,
                .fx = 601.5,
                .fy = 602.25,
                .cx = 318.75,
                .cy = 241.5};
  if (model == CameraModel::kBrownConrady) camera.distortion = {0.1, -0.02, 0.001, -0.002};
  if (model == CameraModel::kKannalaBrandt) camera.distortion = {0.1, -0.02, 0.001, -0.002};
  return camera;
}

void ExpectSame(const Rigid3d& a, const Rigid3d& b) {
  EXPECT_LT((a.rotation - b.rotation).norm(), kExact);
  EXPECT_LT((a.translation - b.translation).norm(), kExact);
}

void ExpectSame(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_NEAR(a.fx, b.fx, kExact);
  EXPECT_NEAR(a.fy, b.fy, kExact);
  EXPECT_NEAR(a.cx, b.cx, kExact);
  EXPECT_NEAR(a.cy, b.cy, kExact);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(a.distortion[i], b.distortion[i], kExact) << i;
}

TEST(PoseWriterTest, RowsComeBackByTheirNumbers) {
  const fs::path file = Temporary("writer_rows.txt");
  WritePoseRows(file, SomePoses());
  const auto poses = std::get<NumberedPoses>(ReadPoseFile(file, PoseConvention::kAuto));
  EXPECT_TRUE(poses.explicit_numbers);
  for (const TrackedPose& pose : SomePoses()) {
    ExpectSame(poses.cam_from_world.at(pose.frame), pose.cam_from_world);
  }
}

class PoseWriterModels : public testing::TestWithParam<CameraModel> {};

TEST_P(PoseWriterModels, TransformsComeBack) {
  const fs::path file = Temporary("writer_transforms.json");
  WriteTransforms(file, SomeCamera(GetParam()), SomePoses());
  const ImageSet set = ReadTransforms(file);
  ASSERT_EQ(set.images.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(set.images[i].name, SomePoses()[i].image);
    ExpectSame(set.images[i].cam_from_world, SomePoses()[i].cam_from_world);
    ExpectSame(set.images[i].camera, SomeCamera(GetParam()));
  }
}

TEST_P(PoseWriterModels, ColmapModelComesBack) {
  const fs::path folder = Temporary("writer_colmap");
  WriteColmapText(folder, SomeCamera(GetParam()), SomePoses());
  const ImageSet set = ReadColmapModel(folder);
  ASSERT_EQ(set.images.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(set.images[i].name, SomePoses()[i].image);
    ExpectSame(set.images[i].cam_from_world, SomePoses()[i].cam_from_world);
    ExpectSame(set.images[i].camera, SomeCamera(GetParam()));
  }
}

TEST_P(PoseWriterModels, CameraYamlComesBack) {
  const fs::path file = Temporary("writer_camera.yaml");
  WriteOpenCvYaml(file, SomeCamera(GetParam()), {"a note: with a colon", "[another"});
  ExpectSame(ReadOpenCvYaml(file), SomeCamera(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Models,
                         PoseWriterModels,
                         testing::Values(CameraModel::kPinhole,
                                         CameraModel::kBrownConrady,
                                         CameraModel::kKannalaBrandt));

// Pictures of two cameras in turn.
std::vector<PosedImage> TwoCameras() {
  std::vector<PosedImage> images;
  const CameraModel models[] = {CameraModel::kBrownConrady, CameraModel::kKannalaBrandt};
  for (int i = 0; i < 4; ++i) {
    images.push_back(
        {"a picture " + std::to_string(i) + ".png", SomeCamera(models[i % 2]), SomePose(0.7 * i)});
  }
  return images;
}

PointCloud SomeCloud() {
  PointCloud cloud(2);
  cloud[0].position = {0.1f, -2.5f, 1e-3f};
  cloud[0].color = {1, 2, 3};
  cloud[1].position = {1234.567f, 0, -1};
  return cloud;
}

TEST(PoseWriterTest, ColmapModelOfSeveralCamerasComesBackWithItsPoints) {
  const fs::path folder = Temporary("writer_colmap_cloud");
  WriteColmapText(folder, TwoCameras(), SomeCloud());
  const ImageSet set = ReadColmapModel(folder);
  ASSERT_EQ(set.images.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(set.images[i].name, TwoCameras()[i].image);
    ExpectSame(set.images[i].cam_from_world, TwoCameras()[i].cam_from_world);
    ExpectSame(set.images[i].camera, TwoCameras()[i].camera);
  }
  ASSERT_EQ(set.sparse_points.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(set.sparse_points[i].cast<float>(), SomeCloud()[i].position);
  }
}

TEST(PoseWriterTest, TransformsOfSeveralCamerasComeBack) {
  const fs::path file = Temporary("writer_transforms_cameras.json");
  WriteTransforms(file, TwoCameras(), "points.ply");
  const ImageSet set = ReadTransforms(file);
  ASSERT_EQ(set.images.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    ExpectSame(set.images[i].cam_from_world, TwoCameras()[i].cam_from_world);
    ExpectSame(set.images[i].camera, TwoCameras()[i].camera);
  }
}

TEST(PoseWriterTest, RefusesACameraThatIsUpsideDown) {
  std::vector<PosedImage> images = TwoCameras();
  images[1].camera.fy *= -1;
  EXPECT_THROW(WriteTransforms(Temporary("bad.json"), images, ""), std::invalid_argument);
  EXPECT_THROW(WriteColmapText(Temporary("bad_colmap"), images, {}), std::invalid_argument);
}

TEST(PoseWriterTest, SaysWhichFileCannotBeWritten) {
  const fs::path file = Temporary("no_such_folder") / "poses.txt";
  try {
    WritePoseRows(file, SomePoses());
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no_such_folder"), std::string::npos);
  }
}

}  // namespace
}  // namespace livemvs
