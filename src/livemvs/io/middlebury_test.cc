#include "livemvs/io/middlebury.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "livemvs/io/dataset_test_scene.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace fs = std::filesystem;

TEST(MiddleburyTest, ViewsAndTheirBoxReadAsTheSame) {
  const TestScene scene = MakeTestScene(PinholeCamera());
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder);
  std::string rows = std::to_string(scene.size()) + "\n";
  Eigen::Matrix3d k;
  k << scene.camera.fx, 0, scene.camera.cx, 0, scene.camera.fy, scene.camera.cy, 0, 0, 1;
  for (std::size_t v = 0; v < scene.size(); ++v) {
    rows += "v" + std::to_string(v) + ".pgm " + Rows(k) + " " +
            Rows(scene.cam_from_world[v].rotation) + " " +
            Rows(scene.cam_from_world[v].translation.transpose()) + "\n";
  }
  WriteText(folder / "scene_par.txt", rows);
  WriteText(folder / "README.txt",
            "5 views\n\nThe (tight) bounding box for the model is\n(-0.25 0.5 -0.125)\n"
            "(0.75 -0.5 0.375)\n\n1 2 3\n");
  const std::unique_ptr<Dataset> dataset = Open(folder);
  ASSERT_TRUE(dataset->box().has_value());
  EXPECT_EQ(dataset->box()->min, Eigen::Vector3d(-0.25, -0.5, -0.125));
  EXPECT_EQ(dataset->box()->max, Eigen::Vector3d(0.75, 0.5, 0.375));
  ExpectScene(*dataset, scene, kTolerance);
}

TEST(MiddleburyTest, ErrorsNameFileLineAndReason) {
  const auto error_of = [](const std::string& text) {
    const fs::path folder = FreshFolder("data");
    WriteGreyImage(folder / "a.pgm", 80);
    WriteGreyImage(folder / "b.pgm", 90);
    WriteText(folder / "x_par.txt", text);
    return OpenError(folder);
  };
  const std::string pose = " 1 0 0 0 1 0 0 0 1 0 0 1\n";
  const std::string a = "a.pgm 100 0 40 0 100 30 0 0 1" + pose;
  const std::string b = "b.pgm 100 0.01 40 0 -100 30 0 0 1" + pose;  // fy < 0: old data sets
  EXPECT_EQ(error_of("2\n" + a + b), "");
  EXPECT_THAT(error_of("3\n" + a + b), HasSubstr("states 3 images, but 2 rows"));
  EXPECT_THAT(error_of("2\n" + a + a), HasSubstr("listed twice"));
  EXPECT_THAT(error_of("1\n" + a), HasSubstr("only one frame"));
  EXPECT_THAT(error_of("x\n" + a), HasSubstr("x_par.txt:1"));
  EXPECT_THAT(error_of("2\n" + a + "b.pgm 100 1 40 0 100 30 0 0 1" + pose), HasSubstr("skew of 1"));
  EXPECT_THAT(error_of("2\n" + a + "b.pgm 0 0 40 0 100 30 0 0 1" + pose), HasSubstr("fx = 0"));
  EXPECT_THAT(error_of("2\n" + a + "b.pgm 9 0 40 0 100 30 0 0 0" + pose), HasSubstr("K is not"));
  EXPECT_THAT(error_of("2\n" + a + "b.pgm 9 0 40 0 9 30 0 0 1 1 0 0 0 1 0 0 0 1 0 0 inf"),
              ::testing::AllOf(HasSubstr("x_par.txt:3"), HasSubstr("'inf'")));
  EXPECT_THAT(error_of("2\n" + a + "b.pgm 9 0 40 0 9 30 0 0 1 1 0 0 0 1 0 0 0 -1 0 0 1"),
              HasSubstr("mirror image"));
  EXPECT_THAT(error_of("2\n" + a + "b.pgm 9 0 40"), HasSubstr("4 words"));
}

}  // namespace
}  // namespace livemvs
