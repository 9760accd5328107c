#include "livemvs/io/colmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>

#include "livemvs/io/dataset_test_scene.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

namespace fs = std::filesystem;

struct ColmapCase {
  const char* name;
  int id;
  CameraModel model;
  bool one_focal_length;
  std::vector<double> distortion;  // in COLMAP's order, which is ours
};

std::vector<double> ColmapParams(const ColmapCase& c, const Camera& camera) {
  std::vector<double> params = {camera.fx};
  if (!c.one_focal_length) params.push_back(camera.fy);
  params.push_back(camera.cx + 0.5);
  params.push_back(camera.cy + 0.5);
  params.insert(params.end(), c.distortion.begin(), c.distortion.end());
  return params;
}

TestScene ColmapScene(const ColmapCase& c) {
  Camera camera = PinholeCamera();
  camera.model = c.model;
  if (c.one_focal_length) camera.fy = camera.fx;
  for (std::size_t i = 0; i < c.distortion.size(); ++i) camera.distortion[i] = c.distortion[i];
  return MakeTestScene(camera);
}

void WriteColmapText(const ColmapCase& c, const TestScene& scene, const fs::path& folder) {
  std::string cameras = "# comment\n7 " + std::string(c.name) + " 96 64";
  for (const double p : ColmapParams(c, scene.camera)) cameras += " " + Exact(p);
  WriteText(folder / "cameras.txt", cameras + "\n");
  std::string images = "# comment\n";
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const std::size_t v = scene.size() - 1 - i;  // not in the order of names
    images += std::to_string(i + 1) + " " +
              Rows(QuaternionWxyz(scene.cam_from_world[v].rotation).transpose()) + " " +
              Rows(scene.cam_from_world[v].translation.transpose()) + " 7 v" + std::to_string(v) +
              ".pgm\n";
    images += i % 2 == 0 ? "\n" : "1.5 2.5 -1 10 11 12 3 4 5 6 7 8\n";
  }
  WriteText(folder / "images.txt", images);
  std::string points = "# comment\n";
  for (const Eigen::Vector3d& p : scene.points) {
    points += "1 " + Rows(p.transpose()) + " 1 2 3 0.5" + (p.x() > 0 ? " 1 2 3 4\n" : "\n");
  }
  WriteText(folder / "points3D.txt", points);
}

template <typename T>
void Put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

void WriteColmapBinary(const ColmapCase& c, const TestScene& scene, const fs::path& folder) {
  std::string cameras;
  Put<std::uint64_t>(cameras, 1);
  Put<std::uint32_t>(cameras, 7);
  Put<std::int32_t>(cameras, c.id);
  Put<std::uint64_t>(cameras, kSceneWidth);
  Put<std::uint64_t>(cameras, kSceneHeight);
  for (const double p : ColmapParams(c, scene.camera)) Put(cameras, p);
  WriteText(folder / "cameras.bin", cameras);
  std::string images;
  Put<std::uint64_t>(images, scene.size());
  for (std::size_t v = 0; v < scene.size(); ++v) {
    Put<std::uint32_t>(images, static_cast<std::uint32_t>(v));
    const Eigen::Vector4d q = QuaternionWxyz(scene.cam_from_world[v].rotation);
    for (int k = 0; k < 4; ++k) Put(images, q[k]);
    for (int k = 0; k < 3; ++k) Put(images, scene.cam_from_world[v].translation[k]);
    Put<std::uint32_t>(images, 7);
    images += "v" + std::to_string(v) + ".pgm" + '\0';
    Put<std::uint64_t>(images, v);  // observations
    images.append(v * 24, 'x');
  }
  WriteText(folder / "images.bin", images);
  std::string points;
  Put<std::uint64_t>(points, scene.points.size());
  for (const Eigen::Vector3d& p : scene.points) {
    Put<std::uint64_t>(points, 1);
    for (int k = 0; k < 3; ++k) Put(points, p[k]);
    points += "rgb";
    Put(points, 0.5);
    Put<std::uint64_t>(points, 2);
    points.append(2 * 8, 'x');
  }
  WriteText(folder / "points3D.bin", points);
}

class ColmapDataset : public ::testing::TestWithParam<ColmapCase> {};

TEST_P(ColmapDataset, TextAndBinaryReadAsTheSameCameras) {
  const TestScene scene = ColmapScene(GetParam());
  for (const bool binary : {false, true}) {
    SCOPED_TRACE(binary ? "binary" : "text");
    const fs::path folder = FreshFolder(binary ? "binary" : "text");
    (binary ? WriteColmapBinary : WriteColmapText)(GetParam(), scene, folder / "sparse" / "0");
    WriteSceneImages(scene, folder / "images");
    for (const fs::path& data : {folder, folder / "sparse" / "0"}) {
      LogCatcher log;
      const std::unique_ptr<Dataset> dataset = Open(data);
      ExpectScene(*dataset, scene, kTolerance);
      EXPECT_THAT(log.warnings(), IsEmpty());
      ASSERT_EQ(dataset->sparse_points().size(), scene.points.size());
      for (std::size_t p = 0; p < scene.points.size(); ++p) {
        EXPECT_EQ(dataset->sparse_points()[p], scene.points[p]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    AllModels,
    ColmapDataset,
    ::testing::Values(
        ColmapCase{"SIMPLE_PINHOLE", 0, CameraModel::kPinhole, true, {}},
        ColmapCase{"PINHOLE", 1, CameraModel::kPinhole, false, {}},
        ColmapCase{"SIMPLE_RADIAL", 2, CameraModel::kBrownConrady, true, {-0.1}},
        ColmapCase{"RADIAL", 3, CameraModel::kBrownConrady, true, {-0.1, 0.02}},
        ColmapCase{"OPENCV", 4, CameraModel::kBrownConrady, false, {-0.1, 0.02, 0.003, -0.002}},
        ColmapCase{
            "OPENCV_FISHEYE", 5, CameraModel::kKannalaBrandt, false, {0.02, -0.01, 0.004, -0.002}},
        ColmapCase{"FULL_OPENCV",
                   6,
                   CameraModel::kBrownConrady,
                   false,
                   {-0.1, 0.02, 0.003, -0.002, 0.01, 0.05, -0.01, 0.002}},
        ColmapCase{"SIMPLE_RADIAL_FISHEYE", 8, CameraModel::kKannalaBrandt, true, {0.03}},
        ColmapCase{"RADIAL_FISHEYE", 9, CameraModel::kKannalaBrandt, true, {0.03, -0.01}}),
    [](const auto& param) { return std::string(param.param.name); });

// --- damaged and hostile models ---

const ColmapCase kPlain = {"PINHOLE", 1, CameraModel::kPinhole, false, {}};

class BrokenColmapTest : public ::testing::Test {
 protected:
  fs::path Model(bool binary) {
    const fs::path folder = FreshFolder("data");
    (binary ? WriteColmapBinary : WriteColmapText)(kPlain, scene_, folder / "sparse" / "0");
    WriteSceneImages(scene_, folder / "images");
    return folder;
  }

  static std::string Slurp(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  // Replaces the first occurrence in a file of the text model.
  std::string ErrorWith(const std::string& file, const std::string& from, const std::string& to) {
    const fs::path folder = Model(false);
    const fs::path path = folder / "sparse" / "0" / file;
    std::string text = Slurp(path);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    WriteText(path, text);
    return OpenError(folder);
  }

  TestScene scene_ = ColmapScene(kPlain);
};

TEST_F(BrokenColmapTest, TextErrorsNameFileLineAndReason) {
  EXPECT_THAT(ErrorWith("cameras.txt", " PINHOLE", " FOV"),
              ::testing::AllOf(HasSubstr("cameras.txt:2"), HasSubstr("FOV is not supported")));
  EXPECT_THAT(ErrorWith("cameras.txt", "110.25", "nan"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(ErrorWith("cameras.txt", "110.25", "0"), HasSubstr("fx = 0"));
  EXPECT_THAT(ErrorWith("cameras.txt", "110.25", "-110.25"), HasSubstr("fx must be positive"));
  EXPECT_THAT(ErrorWith("cameras.txt", " 96 64", " 96 0"), HasSubstr("image size 96 x 0"));
  EXPECT_THAT(ErrorWith("cameras.txt", " 96 64", " 48 32"),
              ::testing::AllOf(HasSubstr("96 x 64"), HasSubstr("48 x 32")));
  EXPECT_THAT(ErrorWith("cameras.txt", "110.25 ", ""), HasSubstr("4 parameters, but 3"));
  EXPECT_THAT(ErrorWith("images.txt", " 7 v4.pgm", " 8 v4.pgm"),
              ::testing::AllOf(HasSubstr("images.txt:2"), HasSubstr("camera 8 is not among")));
  EXPECT_THAT(ErrorWith("images.txt", "\n1 ", "\n1 9 "), HasSubstr("the quaternion's norm is"));
  EXPECT_THAT(ErrorWith("images.txt", "v4.pgm", "../../v4.pgm"), HasSubstr("leaves the data set"));
  EXPECT_THAT(ErrorWith("images.txt", "v4.pgm", "/etc/v4.pgm"), HasSubstr("is absolute"));
  EXPECT_THAT(ErrorWith("images.txt", "v4.pgm", "v3.pgm"), HasSubstr("listed twice"));
  EXPECT_THAT(ErrorWith("points3D.txt", "\n1 ", "\n1 inf "), HasSubstr("points3D.txt:2"));
}

TEST_F(BrokenColmapTest, QuaternionSlightlyOffIsNormalisedWithOneWarning) {
  const fs::path folder = Model(false);
  std::string images;
  for (std::size_t v = 0; v < scene_.size(); ++v) {
    images += "1 " + Rows(1.01 * QuaternionWxyz(scene_.cam_from_world[v].rotation).transpose()) +
              " " + Rows(scene_.cam_from_world[v].translation.transpose()) + " 7 v" +
              std::to_string(v) + ".pgm\n\n";
  }
  WriteText(folder / "sparse" / "0" / "images.txt", images);
  LogCatcher log;
  ExpectScene(*Open(folder), scene_, kTolerance);
  ASSERT_THAT(log.warnings(), SizeIs(1));
  EXPECT_THAT(log.warnings()[0], HasSubstr("norm is 1.01"));
}

TEST_F(BrokenColmapTest, ImagesWithoutASecondLineAreReadToo) {
  const fs::path folder = Model(false);
  const fs::path path = folder / "sparse" / "0" / "images.txt";
  std::string text = Slurp(path), packed;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const std::string line = text.substr(at, end - at + 1);
    if (line.find(".pgm") != std::string::npos) packed += line;
    at = end + 1;
  }
  WriteText(path, packed);
  ExpectScene(*Open(folder), scene_, kTolerance);
}

TEST_F(BrokenColmapTest, AbsurdCountsInBinaryFilesAreRefusedBeforeAnyAllocation) {
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const fs::path folder = Model(true);
    const fs::path path = folder / "sparse" / "0" / file;
    std::string bytes = Slurp(path);
    std::string count;
    Put<std::uint64_t>(count, std::uint64_t{1} << 60);
    WriteText(path, count + bytes.substr(8));
    EXPECT_THAT(OpenError(folder),
                ::testing::AllOf(HasSubstr(file), HasSubstr("1152921504606846976")));
  }
}

TEST_F(BrokenColmapTest, BinaryFilesCutAnywhereAreErrors) {
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const fs::path folder = Model(true);
    const fs::path path = folder / "sparse" / "0" / file;
    const std::string bytes = Slurp(path);
    for (std::size_t size = 1; size < bytes.size(); size += 7) {
      WriteText(path, bytes.substr(0, size));
      EXPECT_THAT(OpenError(folder), HasSubstr(file)) << size;
    }
  }
}

TEST_F(BrokenColmapTest, UnknownBinaryModelIsNamed) {
  const fs::path folder = Model(true);
  const fs::path path = folder / "sparse" / "0" / "cameras.bin";
  std::string bytes = Slurp(path);
  bytes[12] = 10;
  WriteText(path, bytes);
  EXPECT_THAT(OpenError(folder), HasSubstr("THIN_PRISM_FISHEYE is not supported"));
  bytes[12] = 77;
  WriteText(path, bytes);
  EXPECT_THAT(OpenError(folder), HasSubstr("number 77 is not supported"));
}

}  // namespace
}  // namespace livemvs
