#include "livemvs/synth/export.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/picture_codec.h"
#include "livemvs/io/ply.h"
#include "livemvs/synth/labels.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

const SyntheticScene& Plane() {
  static const SyntheticScene scene({.name = "plane"});
  return scene;
}

SequenceOptions Small() {
  SequenceOptions options;
  options.path = DefaultPath("plane");
  options.path.frames = 5;
  options.camera = SyntheticCamera(160, 120);
  return options;
}

fs::path Folder(const std::string& name) {
  const fs::path folder = fs::path(testing::TempDir()) / ("livemvs_export_" + name);
  fs::remove_all(folder);
  return folder;
}

// Exports, opens the folder as a data set, and compares what it says with what was rendered.
void ExpectRoundTrip(const SequenceOptions& sequence,
                     const ExportOptions& options,
                     double max_grey_difference) {
  ExportSequence(Plane(), sequence, options);
  const auto dataset = OpenDataset({.data = options.folder});
  int count = 0;
  while (const auto frame = dataset->Next()) {
    const SyntheticFrame truth = RenderSequenceFrame(Plane(), sequence, count);
    EXPECT_EQ(frame->index, count);
    EXPECT_LT((frame->cam_from_world.rotation - truth.frame.cam_from_world.rotation).norm(), 1e-9);
    EXPECT_LT((frame->cam_from_world.translation - truth.frame.cam_from_world.translation).norm(),
              1e-9);
    EXPECT_EQ(frame->camera.width, sequence.camera.width);
    EXPECT_NEAR(frame->camera.fx, sequence.camera.fx, 1e-6);
    EXPECT_NEAR(frame->camera.cy, sequence.camera.cy, 1e-6);
    for (int i = 0; i < 8; ++i) {
      EXPECT_NEAR(frame->camera.distortion[i], sequence.camera.distortion[i], 1e-9);
    }
    double sum = 0;
    for (int y = 0; y < sequence.camera.height; ++y) {
      for (int x = 0; x < sequence.camera.width; ++x) {
        const Rgb a = frame->picture->ColorAt(x, y), b = truth.frame.picture->ColorAt(x, y);
        sum += std::abs((a[0] + a[1] + a[2]) - (b[0] + b[1] + b[2])) / 3.0;
      }
    }
    EXPECT_LT(sum / (sequence.camera.width * sequence.camera.height), max_grey_difference);
    ++count;
  }
  EXPECT_EQ(count, sequence.path.frames);
}

TEST(Export, VideoOpensAsADataSet) {
  ExportOptions options;
  options.folder = Folder("video");
  options.crf = 12;
  options.depth_every = 2;
  ExpectRoundTrip(Small(), options, 4);
  EXPECT_EQ(ReadMeshPly(options.folder / "mesh.ply").faces.size(), 2u);
  EXPECT_TRUE(fs::exists(options.folder / "README.txt"));
  EXPECT_TRUE(fs::exists(options.folder / "depth" / "000004.pfm"));
  EXPECT_FALSE(fs::exists(options.folder / "depth" / "000003.png"));
  const Image<std::uint16_t> depth = ReadDepthPng(options.folder / "depth" / "000002.png");
  const SyntheticFrame truth = RenderSequenceFrame(Plane(), Small(), 2);
  EXPECT_NEAR(depth(80, 60), 1000 * truth.z_depth(80, 60), 0.51);
}

TEST(Export, ImagesWithDistortionOpenAsADataSet) {
  SequenceOptions sequence = Small();
  sequence.path.frames = 3;
  sequence.camera.model = CameraModel::kBrownConrady;
  sequence.camera.distortion = {-0.2, 0.05, 0.001, 0.002};
  ExportOptions options;
  options.folder = Folder("images");
  options.images = true;
  ExpectRoundTrip(sequence, options, 0.01);
}

TEST(Export, FisheyeKeepsItsModel) {
  SequenceOptions sequence = Small();
  sequence.path.frames = 2;
  sequence.camera.model = CameraModel::kKannalaBrandt;
  sequence.camera.distortion = {0.02, -0.01, 0.001, 0};
  ExportOptions options;
  options.folder = Folder("fisheye");
  options.images = true;
  ExpectRoundTrip(sequence, options, 0.01);
  EXPECT_EQ(OpenDataset({.data = options.folder})->views()[0].camera.model,
            CameraModel::kKannalaBrandt);
}

TEST(Export, WritesTheLabelsThatAreDue) {
  const SequenceOptions sequence = Small();
  ExportOptions options;
  options.folder = Folder("labels");
  options.images = true;
  options.labels_every = 2;
  ExportSequence(Plane(), sequence, options);
  for (int i = 0; i < sequence.path.frames; ++i) {
    const fs::path file = options.folder / "labels" / ("00000" + std::to_string(i) + ".png");
    ASSERT_EQ(fs::exists(file), i % 2 == 0) << file;
    if (i % 2 != 0) continue;
    const SyntheticFrame truth = RenderSequenceFrame(Plane(), sequence, i);
    const Image<std::uint8_t> labels = LabelSequenceFrame(Plane(), sequence, truth);
    const Image<std::uint16_t> read = ReadDepthPng(file);
    ASSERT_EQ(read.width(), labels.width());
    ASSERT_EQ(read.height(), labels.height());
    for (int y = 0; y < labels.height(); ++y) {
      for (int x = 0; x < labels.width(); ++x) ASSERT_EQ(read(x, y), labels(x, y));
    }
  }
  options.labels_every = -1;
  EXPECT_THROW(ExportSequence(Plane(), sequence, options), std::invalid_argument);
}

TEST(Export, StopsWhenAskedAndKeepsWhatIsThere) {
  ExportOptions options;
  options.folder = Folder("stopped");
  options.images = true;
  options.progress = [](int done) { return done < 3; };
  ExportSequence(Plane(), Small(), options);
  EXPECT_EQ(OpenDataset({.data = options.folder})->views().size(), 3u);
}

TEST(Export, SaysWhereItCannotWrite) {
  const fs::path file = Folder("file");
  std::ofstream(file) << "in the way";
  ExportOptions options;
  options.folder = file / "inside";
  try {
    ExportSequence(Plane(), Small(), options);
    FAIL() << "nothing thrown";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kOutOfResource);
    EXPECT_NE(std::string(e.what()).find(options.folder.string()), std::string::npos);
  }
}

}  // namespace
}  // namespace livemvs
