#include "livemvs/io/transforms.h"

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

std::string TransformsFrames(const TestScene& scene, const std::string& extension) {
  std::string text = "\"frames\": [";
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const std::size_t v = scene.size() - 1 - i;
    const Eigen::Matrix4d m = OpenGlPose(scene.cam_from_world[v]);
    text += std::string(i == 0 ? "" : ",") + "{\"file_path\": \"./images/v" + std::to_string(v) +
            extension + "\", \"transform_matrix\": [";
    for (int r = 0; r < 4; ++r) {
      text += r == 0 ? "[" : ",[";
      for (int c = 0; c < 4; ++c) text += (c == 0 ? "" : ",") + Exact(m(r, c));
      text += "]";
    }
    text += "]}";
  }
  return text + "]";
}

std::string TransformsIntrinsics(const Camera& c) {
  return "\"w\": 96, \"h\": 64, \"fl_x\": " + Exact(c.fx) + ", \"fl_y\": " + Exact(c.fy) +
         ", \"cx\": " + Exact(c.cx + 0.5) + ", \"cy\": " + Exact(c.cy + 0.5) + ", ";
}

TEST(TransformsTest, WithBrownConrady) {
  const TestScene scene = MakeTestScene(BrownConradyCamera());
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder / "images");
  WriteText(folder / "transforms.json",
            "{\"camera_model\": \"OPENCV\", " + TransformsIntrinsics(scene.camera) +
                "\"k1\": -0.12, \"k2\": 0.03, \"p1\": 0.002, \"p2\": -0.003, " +
                TransformsFrames(scene, ".pgm") + "}");
  LogCatcher log;
  ExpectScene(*Open(folder), scene, kTolerance);
  ExpectScene(*Open(folder / "transforms.json"), scene, kTolerance);
  EXPECT_THAT(log.warnings(), IsEmpty());
}

TEST(TransformsTest, WithFisheyeAndWithoutExtension) {
  const TestScene scene = MakeTestScene(KannalaBrandtCamera());
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder / "images");
  // What a file is shows from its contents, so a PGM may be called .png.
  for (std::size_t v = 0; v < scene.size(); ++v) {
    const std::string stem = "v" + std::to_string(v);
    fs::rename(folder / "images" / (stem + ".pgm"), folder / "images" / (stem + ".png"));
  }
  WriteText(folder / "transforms.json",
            "{\"camera_model\": \"OPENCV_FISHEYE\", " + TransformsIntrinsics(scene.camera) +
                "\"k1\": 0.02, \"k2\": -0.01, \"k3\": 0.004, \"k4\": -0.002, " +
                TransformsFrames(scene, "") + "}");
  ExpectScene(*Open(folder), scene, kTolerance);
}

TEST(TransformsTest, WithTheAngleOnly) {
  Camera camera = PinholeCamera();
  camera.fy = camera.fx;
  camera.cx = (kSceneWidth - 1) / 2.0;  // the middle of the image
  camera.cy = (kSceneHeight - 1) / 2.0;
  const TestScene scene = MakeTestScene(camera);
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder / "images");
  const double angle = 2 * std::atan(kSceneWidth / (2 * camera.fx));
  WriteText(folder / "transforms.json",
            "{\"w\": 96, \"h\": 64, \"camera_angle_x\": " + Exact(angle) + ", " +
                TransformsFrames(scene, ".pgm") + "}");
  ExpectScene(*Open(folder), scene, kTolerance);
}

TEST(TransformsTest, WithIntrinsicsOfEachFrame) {
  const TestScene scene = MakeTestScene(PinholeCamera());
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder / "images");
  std::string frames = TransformsFrames(scene, ".pgm");
  for (std::size_t at = 0; (at = frames.find("{\"file_path\"", at)) != std::string::npos; ++at) {
    frames.insert(at + 1, TransformsIntrinsics(scene.camera));
  }
  WriteText(folder / "transforms.json", "{\"fl_x\": 1, \"cx\": 1, \"cy\": 1, " + frames + "}");
  ExpectScene(*Open(folder), scene, kTolerance);
}

// --- damaged and hostile files ---

class BrokenTransformsTest : public ::testing::Test {
 protected:
  std::string Valid() const {
    return "{" + TransformsIntrinsics(scene_.camera) + TransformsFrames(scene_, ".pgm") + "}";
  }

  std::string ErrorOf(const std::string& text) const {
    const fs::path folder = FreshFolder("data");
    WriteSceneImages(scene_, folder / "images");
    WriteText(folder / "transforms.json", text);
    return OpenError(folder);
  }

  std::string ErrorWith(const std::string& from, const std::string& to) const {
    std::string text = Valid();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return ErrorOf(text.replace(at, from.size(), to));
  }

  TestScene scene_ = MakeTestScene(PinholeCamera());
};

TEST_F(BrokenTransformsTest, ErrorsNameFileFrameAndReason) {
  EXPECT_EQ(ErrorOf(Valid()), "");
  EXPECT_THAT(ErrorOf(""), HasSubstr("empty"));
  EXPECT_THAT(ErrorOf("{\"frames\": ["), HasSubstr("not valid JSON"));
  EXPECT_THAT(ErrorOf("[1, 2]"), HasSubstr("no list 'frames'"));
  EXPECT_THAT(ErrorOf("{\"frames\": [3]}"), HasSubstr("frame 0: is not an object"));
  EXPECT_THAT(ErrorOf("{\"frames\": []}"), HasSubstr("Supported are"));
  EXPECT_THAT(ErrorWith("\"fl_x\": 110.25", "\"fl_x\": 0"), HasSubstr("fx = 0"));
  EXPECT_THAT(ErrorWith("\"fl_x\": 110.25", "\"fl_x\": \"a\""),
              HasSubstr("'fl_x' is not a finite"));
  EXPECT_THAT(ErrorWith("\"fl_x\": 110.25", "\"fl_x\": 1e999"), HasSubstr("transforms.json"));
  EXPECT_THAT(ErrorWith("\"w\": 96", "\"w\": 1e300"), HasSubstr("'w' is not an image size"));
  EXPECT_THAT(ErrorWith("\"w\": 96, \"h\": 64", "\"w\": 192, \"h\": 128"),
              ::testing::AllOf(HasSubstr("96 x 64"), HasSubstr("192 x 128")));
  EXPECT_THAT(ErrorWith("\"w\": 96", "\"camera_model\": \"FISHEYE624\", \"w\": 96"),
              HasSubstr("'FISHEYE624' is not supported"));
  EXPECT_THAT(ErrorWith("\"w\": 96", "\"k4\": 0.1, \"w\": 96"), HasSubstr("'k4'"));
  EXPECT_THAT(ErrorWith("transform_matrix", "matrix"), HasSubstr("frame 0: 'transform_matrix'"));
  EXPECT_THAT(ErrorWith("[[", "[[7,"), HasSubstr("frame 0: 'transform_matrix'"));
  EXPECT_THAT(ErrorWith("[[", "[[1"), HasSubstr("frame 0: not a rotation"));
  EXPECT_THAT(ErrorWith(",1]]}", ",2]]}"), HasSubstr("last row"));
}

TEST_F(BrokenTransformsTest, MirroredRotationIsRefused) {
  for (Rigid3d& pose : scene_.cam_from_world) pose.rotation.row(0) *= -1;
  EXPECT_THAT(ErrorOf(Valid()), HasSubstr("mirror image"));
}

TEST_F(BrokenTransformsTest, RoundedRotationIsMadeExact) {
  Rigid3d& pose = scene_.cam_from_world[0];
  const Eigen::Matrix3d exact = pose.rotation;
  pose.rotation.array() += 1e-3;
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene_, folder / "images");
  WriteText(folder / "transforms.json", Valid());
  const Eigen::Matrix3d read = Open(folder)->views()[0].cam_from_world.rotation;
  EXPECT_LT((read.transpose() * read - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((read - exact).norm(), 5e-3);
}

TEST_F(BrokenTransformsTest, DeepNestingIsAnErrorNotACrash) {
  const std::string open(10000, '[');
  EXPECT_THAT(ErrorOf("{\"frames\": " + open), HasSubstr("nested deeper than 64"));
  EXPECT_THAT(ErrorOf(std::string(10000, '[') + std::string(10000, ']')),
              HasSubstr("nested deeper than 64"));
}

TEST_F(BrokenTransformsTest, PathsThatLeaveTheFolderAreRefused) {
  EXPECT_THAT(ErrorWith("./images/v4.pgm", "../v4.pgm"), HasSubstr("leaves the data set's folder"));
  EXPECT_THAT(ErrorWith("./images/v4.pgm", "images/../../v4"), HasSubstr("leaves the data set"));
  EXPECT_THAT(ErrorWith("./images/v4.pgm", "/etc/passwd"), HasSubstr("is absolute"));
  EXPECT_THAT(ErrorWith("./images/v4.pgm", ""), HasSubstr("no 'file_path'"));
}

TEST_F(BrokenTransformsTest, LinksThatLeaveTheFolderAreRefused) {
  const fs::path elsewhere = FreshFolder("elsewhere");
  WriteSceneImages(scene_, elsewhere);
  const fs::path folder = FreshFolder("data");
  fs::create_directory_symlink(elsewhere, folder / "images");
  WriteText(folder / "transforms.json", Valid());
  EXPECT_THAT(OpenError(folder), HasSubstr("leaves the data set's folder"));
}

TEST_F(BrokenTransformsTest, MissingImagesAreLeftOutWithOneWarning) {
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene_, folder / "images");
  WriteText(folder / "transforms.json", Valid());
  fs::remove(folder / "images" / "v0.pgm");
  fs::remove(folder / "images" / "v3.pgm");
  LogCatcher log;
  const std::unique_ptr<Dataset> dataset = Open(folder);
  ASSERT_THAT(dataset->views(), SizeIs(3));
  EXPECT_EQ(dataset->views()[0].index, 1);  // missing ones are counted
  ASSERT_THAT(log.warnings(), SizeIs(1));
  EXPECT_THAT(log.warnings()[0], HasSubstr("2 of 5 images"));
  fs::remove_all(folder / "images");
  EXPECT_THAT(OpenError(folder), HasSubstr("5 of them missing"));
}

}  // namespace
}  // namespace livemvs
