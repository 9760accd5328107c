#include "livemvs/io/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "livemvs/core/error.h"
#include "livemvs/io/dataset_test_scene.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;

namespace fs = std::filesystem;

std::string YamlError(const std::string& text) {
  const fs::path file = FreshFolder("data") / "camera.yaml";
  WriteText(file, text);
  try {
    ReadOpenCvYaml(file);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(CalibrationTest, OpenCvYaml) {
  const fs::path file = FreshFolder("data") / "camera.yaml";
  Camera camera = BrownConradyCamera();
  camera.distortion[4] = 0.0125;
  WriteText(file, OpenCvYaml(camera));
  const Camera read = ReadCamera(file.string());
  EXPECT_EQ(read.model, CameraModel::kBrownConrady);
  EXPECT_EQ(read.fx, camera.fx);
  EXPECT_EQ(read.fy, camera.fy);
  EXPECT_EQ(read.cx, camera.cx);  // OpenCV's pixel centres are integers, too
  EXPECT_EQ(read.cy, camera.cy);
  EXPECT_EQ(read.distortion, camera.distortion);
  EXPECT_EQ(read.width, kSceneWidth);
  EXPECT_EQ(read.height, kSceneHeight);
}

TEST(CalibrationTest, FisheyeAndPlainLists) {
  const fs::path file = FreshFolder("data") / "camera.yml";
  WriteText(file,
            "camera_matrix: [[100, 0, 48], [0, 101, 32], [0, 0, 1]]\n"
            "distortion_model: equidistant\ndistortion_coefficients: [0.1, 0.2, 0.3, 0.4]\n");
  const Camera read = ReadCamera(file.string());
  EXPECT_EQ(read.model, CameraModel::kKannalaBrandt);
  EXPECT_EQ(read.distortion[3], 0.4);
  EXPECT_EQ(read.width, 0);
}

TEST(CalibrationTest, CameraAsAList) {
  const Camera pinhole = ReadCamera("100,-101,48,32");
  EXPECT_EQ(pinhole.model, CameraModel::kPinhole);
  EXPECT_EQ(pinhole.fy, -101);  // accepted: some data sets have the image upside down
  const Camera distorted = ReadCamera("100,101,48,32,0.1,0.2,0.3,0.4,0.5");
  EXPECT_EQ(distorted.model, CameraModel::kBrownConrady);
  EXPECT_EQ(distorted.distortion[4], 0.5);
}

TEST(CalibrationTest, ErrorsNameTheFileAndTheReason) {
  const std::string matrix = "camera_matrix: [100, 0, 48, 0, 100, 32, 0, 0, 1]\n";
  EXPECT_EQ(YamlError(matrix), "");
  EXPECT_THAT(YamlError("a: b\n"), HasSubstr("no 'camera_matrix'"));
  EXPECT_THAT(YamlError("- 1\n- 2\n"), HasSubstr("not a YAML map"));
  EXPECT_THAT(YamlError("a: [1, 2\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(YamlError("camera_matrix: 3\n"), HasSubstr("no list of numbers"));
  EXPECT_THAT(YamlError("camera_matrix: [1, 2, 3]\n"), HasSubstr("3 numbers, not 9"));
  EXPECT_THAT(YamlError("camera_matrix: [1, 2, 3, 0, 1, 1, 0, 0, 1]\n"), HasSubstr("(fx 0 cx;"));
  EXPECT_THAT(YamlError("camera_matrix: [.nan, 0, 1, 0, 1, 1, 0, 0, 1]\n"), HasSubstr("'.nan'"));
  EXPECT_THAT(YamlError("camera_matrix: [0, 0, 1, 0, 1, 1, 0, 0, 1]\n"), HasSubstr("fx = 0"));
  EXPECT_THAT(YamlError(matrix + "distortion_coefficients: [1, 2, 3]\n"),
              HasSubstr("3 distortion"));
  EXPECT_THAT(YamlError(matrix + "image_width: -3\nimage_height: 9\n"), HasSubstr("'image_width'"));
  EXPECT_THAT(YamlError(matrix + "image_width: {a: 3}\n"), HasSubstr("'image_width'"));
}

TEST(CalibrationTest, HostileYamlIsAnErrorNotACrash) {
  EXPECT_THAT(YamlError("a: " + std::string(100000, '[')), HasSubstr("camera.yaml"));
  EXPECT_THAT(YamlError("a: " + std::string(100000, '{')), HasSubstr("camera.yaml"));
  std::string dashes;
  for (int i = 0; i < 20000; ++i) dashes += "- ";
  EXPECT_THAT(YamlError(dashes + "1"), HasSubstr("camera.yaml"));
  EXPECT_THAT(YamlError(std::string((1 << 20) + 1, 'x')), HasSubstr("more than the"));
  EXPECT_THAT(YamlError("%YAML:1.0"), HasSubstr("camera.yaml"));
}

TEST(CalibrationTest, WhatIsWrittenReadsAsTheSameCamera) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500.1;
  camera.fy = 501.2;
  camera.cx = 319.3;
  camera.cy = 239.4;
  const fs::path file = FreshFolder("data") / "camera.yaml";
  for (const CameraModel model : {CameraModel::kBrownConrady, CameraModel::kKannalaBrandt}) {
    camera.model = model;
    for (const int coefficients : {0, 4, 5, 8}) {
      if (model == CameraModel::kKannalaBrandt && coefficients > 4) continue;
      camera.distortion = {};
      for (int i = 0; i < coefficients; ++i) camera.distortion[i] = 0.01 * (i + 1) / 3;
      WriteOpenCvYaml(file, camera);
      const Camera back = ReadOpenCvYaml(file);
      // Without distortion a Brown–Conrady camera is a pinhole camera.
      if (coefficients > 0) {
        EXPECT_EQ(back.model, camera.model);
      }
      EXPECT_EQ(back.width, 640);
      EXPECT_EQ(back.height, 480);
      EXPECT_EQ(back.fx, camera.fx);
      EXPECT_EQ(back.fy, camera.fy);
      EXPECT_EQ(back.cx, camera.cx);
      EXPECT_EQ(back.cy, camera.cy);
      EXPECT_EQ(back.distortion, camera.distortion);
    }
  }
}

}  // namespace
}  // namespace livemvs
