#include "livemvs/io/dataset_posed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cstring>
#include <functional>
#include <stdexcept>

#include "livemvs/core/error.h"
#include "livemvs/io/dataset_test_scene.h"
#include "livemvs/io/video_writer.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace fs = std::filesystem;

void WriteVideo(const TestScene& scene, const fs::path& path) {
  VideoWriterOptions options;
  options.width = kSceneWidth;
  options.height = kSceneHeight;
  options.frames_per_second = 25;
  options.full_range = true;
  VideoWriter writer(path, options);
  for (std::size_t v = 0; v < scene.size(); ++v) {
    Image<std::uint8_t> grey(kSceneWidth, kSceneHeight);
    for (int y = 0; y < kSceneHeight; ++y) {
      std::memset(grey.Row(y), GreyOfView(v), static_cast<std::size_t>(kSceneWidth));
    }
    writer.Write(grey);
  }
  writer.Finish();
}

struct PoseFileCase {
  const char* name;
  PoseConvention convention;
  std::function<std::string(std::size_t, const Rigid3d&)> row;
};

const std::vector<PoseFileCase>& PoseFileCases() {
  static const std::vector<PoseFileCase> cases = {
      {"numbered",
       PoseConvention::kAuto,
       [](std::size_t v, const Rigid3d& p) {
         return std::to_string(v) + " " + Rows(Matrix34(p)) + "\n";
       }},
      {"rows",
       PoseConvention::kCamFromWorld,
       [](std::size_t, const Rigid3d& p) { return Rows(Matrix34(p)) + "\n"; }},
      {"world_from_cam",
       PoseConvention::kWorldFromCam,
       [](std::size_t, const Rigid3d& p) {
         Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
         m.topRows<3>() = Matrix34(p);
         return Rows(m.inverse().topRows<3>()) + "\n";
       }},
      {"opengl",
       PoseConvention::kWorldFromCamOpenGl,
       [](std::size_t, const Rigid3d& p) { return Rows(OpenGlPose(p).topRows<3>()) + "\n"; }},
      {"trajectory", PoseConvention::kAuto, [](std::size_t v, const Rigid3d& p) {
         return TumRow(static_cast<double>(v) / 25, p);
       }}};
  return cases;
}

class PoseFileDataset : public ::testing::TestWithParam<std::size_t> {};

TEST_P(PoseFileDataset, ImagesAndVideo) {
  const PoseFileCase& c = PoseFileCases()[GetParam()];
  const TestScene scene = MakeTestScene(BrownConradyCamera());
  const fs::path folder = FreshFolder("images");
  WriteSceneImages(scene, folder / "images");
  std::string poses;
  for (std::size_t v = 0; v < scene.size(); ++v) poses += c.row(v, scene.cam_from_world[v]);
  WriteText(folder / "poses.txt", poses);
  WriteText(folder / "camera.yaml", OpenCvYaml(scene.camera));
  DatasetOptions options;
  options.data = folder;
  options.pose_convention = c.convention;
  ExpectScene(*OpenDataset(options), scene, kTolerance);

  const fs::path video_folder = FreshFolder("video");
  const fs::path video = video_folder / "film.mp4";
  WriteVideo(scene, video);
  options.data = video;
  options.poses = folder / "poses.txt";
  const Camera& k = scene.camera;
  options.camera = Exact(k.fx) + "," + Exact(k.fy) + "," + Exact(k.cx) + "," + Exact(k.cy) +
                   ",-0.12,0.03,0.002,-0.003";
  ExpectScene(*OpenDataset(options), scene, kTolerance, /*grey_tolerance=*/3);

  // All by itself from the folder.
  fs::copy(folder / "poses.txt", video_folder / "poses.txt");
  fs::copy(folder / "camera.yaml", video_folder / "camera.yaml");
  options.data = video_folder;
  options.poses.clear();
  options.camera.clear();
  ExpectScene(*OpenDataset(options), scene, kTolerance, /*grey_tolerance=*/3);
}

INSTANTIATE_TEST_SUITE_P(AllRows,
                         PoseFileDataset,
                         ::testing::Range(std::size_t{0}, std::size_t{5}),
                         [](const auto& param) {
                           return std::string(PoseFileCases()[param.param].name);
                         });

// --- numbers that do not meet ---

class PosedFolderTest : public ::testing::Test {
 protected:
  static std::string PoseRows(const TestScene& scene, bool numbered, std::size_t count) {
    std::string rows;
    for (std::size_t v = 0; v < count; ++v) {
      rows += (numbered ? std::to_string(v) + " " : "") +
              Rows(Matrix34(scene.cam_from_world[v % scene.size()])) + "\n";
    }
    return rows;
  }

  // Five images with intrinsics.txt and these poses.
  fs::path Folder(const std::string& poses, const std::string& size = " 96 64") const {
    const fs::path folder = FreshFolder("data");
    WriteSceneImages(scene_, folder);
    const Camera& c = scene_.camera;
    WriteText(folder / "intrinsics.txt",
              Exact(c.fx) + " " + Exact(c.fy) + " " + Exact(c.cx) + " " + Exact(c.cy) + size);
    WriteText(folder / "poses.txt", poses);
    return folder;
  }

  TestScene scene_ = MakeTestScene(PinholeCamera());
};

TEST_F(PosedFolderTest, IntrinsicsWithAndWithoutTheSize) {
  ExpectScene(*Open(Folder(PoseRows(scene_, true, 5))), scene_, kTolerance);
  ExpectScene(*Open(Folder(PoseRows(scene_, false, 5), "")), scene_, kTolerance);
}

TEST_F(PosedFolderTest, WrongNumberOfPosesNamesBothNumbers) {
  for (const std::size_t poses : {4u, 6u}) {
    EXPECT_THAT(OpenError(Folder(PoseRows(scene_, false, poses))),
                ::testing::AllOf(HasSubstr("for " + std::to_string(poses) + " frames"),
                                 HasSubstr("has 5;"),
                                 HasSubstr("put the frame's number")));
  }
  EXPECT_THAT(OpenError(Folder(PoseRows(scene_, true, 6))), HasSubstr("for 6 frames"));
}

TEST_F(PosedFolderTest, NumberedPosesMayLeaveImagesOut) {
  LogCatcher log;
  const std::unique_ptr<Dataset> dataset = Open(Folder(PoseRows(scene_, true, 3)));
  EXPECT_THAT(dataset->views(), SizeIs(3));
  EXPECT_EQ(dataset->statistics().skipped, 2);
  ASSERT_THAT(log.warnings(), SizeIs(1));
  EXPECT_THAT(log.warnings()[0], HasSubstr("no pose for 2 of 5 images"));
}

TEST_F(PosedFolderTest, SizeOfTheCalibrationMustBeThePictures) {
  EXPECT_THAT(OpenError(Folder(PoseRows(scene_, true, 5), " 192 128")),
              ::testing::AllOf(HasSubstr("96 x 64"), HasSubstr("192 x 128")));
}

TEST_F(PosedFolderTest, RangeOfFrames) {
  DatasetOptions options;
  options.data = Folder(PoseRows(scene_, true, 5));
  options.first_frame = 1;
  options.step = 2;
  const std::unique_ptr<Dataset> dataset = OpenDataset(options);
  ASSERT_THAT(dataset->views(), SizeIs(2));
  EXPECT_EQ(dataset->views()[1].index, 3);
  options.last_frame = 2;
  EXPECT_THAT(OpenError(options), HasSubstr("only one frame"));
  options.step = 0;
  EXPECT_THROW(OpenDataset(options), std::invalid_argument);
  options.step = 1;
  options.last_frame = 0;
  EXPECT_THROW(OpenDataset(options), std::invalid_argument);
}

TEST_F(PosedFolderTest, DamagedImagesAreLeftOutWithOneWarning) {
  const fs::path folder = Folder(PoseRows(scene_, true, 5));
  WriteText(folder / "v0.pgm", "not an image");
  WriteText(folder / "v2.pgm", "P5 96 64");
  LogCatcher log;
  const std::unique_ptr<Dataset> dataset = Open(folder);
  std::vector<std::int64_t> indices;
  while (const auto frame = dataset->Next()) indices.push_back(frame->index);
  EXPECT_THAT(indices, ::testing::ElementsAre(1, 3, 4));
  EXPECT_EQ(dataset->statistics().skipped, 2);
  EXPECT_THAT(log.warnings(), SizeIs(1));
}

TEST_F(PosedFolderTest, AnotherSizeInTheMiddleIsAnError) {
  const fs::path folder = Folder(PoseRows(scene_, true, 5));
  WriteGreyImage(folder / "v3.pgm", 100, 48, 32);
  const std::unique_ptr<Dataset> dataset = Open(folder);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(dataset->Next().has_value());
  EXPECT_THROW(dataset->Next(), Error);
}

TEST_F(PosedFolderTest, WhatIsMissingIsNamed) {
  const fs::path folder = Folder(PoseRows(scene_, true, 5));
  fs::remove(folder / "intrinsics.txt");
  EXPECT_THAT(OpenError(folder), HasSubstr("--camera"));
  fs::remove(folder / "poses.txt");
  EXPECT_THAT(OpenError(folder), HasSubstr("--poses"));
  EXPECT_THAT(OpenError(FreshFolder("empty")), HasSubstr("Supported are"));
  EXPECT_THAT(OpenError(folder / "nothing"), HasSubstr("no such file or folder"));
  EXPECT_THAT(OpenError(fs::path(folder / "v0.pgm")), HasSubstr("not a file that defines"));
}

TEST_F(PosedFolderTest, AListOfTheCameraIsChecked) {
  DatasetOptions options;
  options.data = Folder(PoseRows(scene_, true, 5));
  for (const char* camera :
       {"100,100,48", "100,100,48,x", "0,100,48,32", "1,1,1,1,1", "1,1,nan,1"}) {
    options.camera = camera;
    EXPECT_THROW(OpenDataset(options), std::invalid_argument) << camera;
  }
  options.camera = "nothing.yaml";
  EXPECT_THAT(OpenError(options), HasSubstr("nothing.yaml: no such file"));
}

TEST_F(PosedFolderTest, VideoWithFewerOrMorePosesThanFrames) {
  const fs::path folder = FreshFolder("data");
  WriteVideo(scene_, folder / "film.mp4");
  WriteText(folder / "camera.yaml", OpenCvYaml(scene_.camera));
  WriteText(folder / "poses.txt", PoseRows(scene_, false, 3));  // no telling which frames are meant
  EXPECT_THAT(OpenError(folder), ::testing::AllOf(HasSubstr("for 3 frames"), HasSubstr("has 5;")));
  WriteText(folder / "poses.txt", PoseRows(scene_, true, 3));
  {
    LogCatcher log;
    const std::unique_ptr<Dataset> dataset = Open(folder);
    EXPECT_THAT(dataset->views(), SizeIs(3));
    int frames = 0;
    while (dataset->Next()) ++frames;
    EXPECT_EQ(frames, 3);
    EXPECT_EQ(dataset->statistics().skipped, 2);
    ASSERT_THAT(log.warnings(), SizeIs(1));
    EXPECT_THAT(log.warnings()[0], HasSubstr("no pose for 2 frames"));
  }
  WriteText(folder / "poses.txt", PoseRows(scene_, true, 7));
  EXPECT_THAT(OpenError(folder), ::testing::AllOf(HasSubstr("for 7 frames"), HasSubstr("has 5;")));
  WriteText(folder / "poses.txt", TumRow(1e9, scene_.cam_from_world[0]));
  EXPECT_THAT(OpenError(folder), HasSubstr("seconds since the video's first frame"));
  WriteText(folder / "fake.mp4", "this is text");
  EXPECT_THAT(OpenError(folder), HasSubstr("several videos"));
  EXPECT_THAT(OpenError(folder / "fake.mp4"), HasSubstr("fake.mp4"));
}

}  // namespace
}  // namespace livemvs
