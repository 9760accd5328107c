#include "livemvs/io/pose_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "livemvs/core/error.h"
#include "livemvs/io/dataset_test_scene.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace fs = std::filesystem;

TEST(CamsFileTest, ReadsAsTheSameCameras) {
  const TestScene scene = MakeTestScene(BrownConradyCamera());
  const fs::path folder = FreshFolder("data");
  WriteSceneImages(scene, folder);
  std::string rows = "# image width height fx fy cx cy k1 k2 p1 p2 R t\n";
  for (std::size_t v = 0; v < scene.size(); ++v) {
    const Camera& c = scene.camera;
    rows += "v" + std::to_string(v) + ".pgm 96 64 " + Exact(c.fx) + " " + Exact(c.fy) + " " +
            Exact(c.cx) + " " + Exact(c.cy) + " -0.12 0.03 0.002 -0.003 " +
            Rows(scene.cam_from_world[v].rotation) + " " +
            Rows(scene.cam_from_world[v].translation.transpose()) + "\n";
  }
  WriteText(folder / "cams.txt", rows);
  ExpectScene(*Open(folder), scene, kTolerance);
}

TEST(CamsFileTest, ErrorsNameFileLineAndReason) {
  const auto error_of = [](const std::string& text) {
    const fs::path folder = FreshFolder("data");
    WriteGreyImage(folder / "a.pgm", 80);
    WriteGreyImage(folder / "b.pgm", 90);
    WriteText(folder / "cams.txt", text);
    return OpenError(folder);
  };
  const std::string rest = " 100 100 40 30 0 0 0 0 1 0 0 0 1 0 0 0 1 0 0 1\n";
  EXPECT_EQ(error_of("a.pgm 96 64" + rest + "b.pgm 96 64" + rest), "");
  EXPECT_THAT(error_of("a.pgm 96 64" + rest + "b.pgm 1e10 64" + rest), HasSubstr("cams.txt:2"));
  EXPECT_THAT(error_of("a.pgm 96 64" + rest + "b.pgm 64" + rest), HasSubstr("22 words"));
  EXPECT_THAT(error_of("a.pgm 10 10" + rest + "b.pgm 10 10" + rest), HasSubstr("10 x 10"));
  EXPECT_THAT(error_of(std::string("a\0b", 3)), HasSubstr("not a text file"));
}

TEST(PoseFileTest, ErrorsNameFileLineAndReason) {
  const auto error_of = [](const std::string& text) -> std::string {
    const fs::path file = FreshFolder("data") / "poses.txt";
    WriteText(file, text);
    try {
      ReadPoseFile(file, PoseConvention::kAuto);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  EXPECT_EQ(error_of("# x\n" + good + "\r\n" + good), "");
  EXPECT_EQ(error_of("5 " + good + "3 " + good), "");
  EXPECT_THAT(error_of("# only comments\n"), HasSubstr("holds no pose"));
  EXPECT_THAT(error_of(good + "1 2 3\n"), HasSubstr("poses.txt:2: 3 numbers"));
  EXPECT_THAT(error_of(good + "1 " + good), HasSubstr("poses.txt:2: 13 numbers"));
  EXPECT_THAT(error_of("5 " + good + "5 " + good), HasSubstr("frame 5 has a pose already"));
  EXPECT_THAT(error_of("-1 " + good), HasSubstr("frame's number"));
  EXPECT_THAT(error_of("1e300 " + good), HasSubstr("frame's number"));
  EXPECT_THAT(error_of("1 0 0 0 0 1 0 0 0 0 1 nan\n"), HasSubstr("'nan'"));
  EXPECT_THAT(error_of("1 0 0 0 0 1 0 0 0 0 1 1e999\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(error_of("1 0 0 0 0 1 0 0 0 0 1.1 0\n"), HasSubstr("not a rotation"));
  EXPECT_THAT(error_of("1 0 0 0 0 1 0 0 0 0 -1 0\n"), HasSubstr("mirror image"));
  EXPECT_THAT(error_of("hello world\n"), HasSubstr("'hello' is not a finite number"));
}

TEST(PoseFileTest, HugeFilesAreRefusedUnread) {
  const fs::path file = FreshFolder("data") / "poses.txt";
  WriteText(file, "1");
  fs::resize_file(file, (std::uintmax_t{256} << 20) + 1);  // a hole: takes no space
  EXPECT_THROW(ReadPoseFile(file, PoseConvention::kAuto), Error);
}

}  // namespace
}  // namespace livemvs
