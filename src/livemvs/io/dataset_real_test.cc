// The shared real recordings, each opened by its folder alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "livemvs/io/dataset.h"
#include "livemvs/io/dataset_test_scene.h"

namespace livemvs {
namespace {

using namespace testing_io;  // NOLINT
using ::testing::HasSubstr;
using ::testing::SizeIs;

namespace fs = std::filesystem;

struct RealCase {
  const char* folder;
  std::size_t views;
  int width, height;
  const char* description;
  double fx;                      // as in the files
  double cx;                      // in our convention
  double extent_min, extent_max;  // diagonal of the cameras' bounding box [scene]
};

class RealDataset : public ::testing::TestWithParam<RealCase> {};

double ExtentOfPath(const Dataset& dataset) {
  Eigen::Vector3d low = dataset.views()[0].cam_from_world.Center(), high = low;
  for (const DatasetView& view : dataset.views()) {
    low = low.cwiseMin(view.cam_from_world.Center());
    high = high.cwiseMax(view.cam_from_world.Center());
  }
  return (high - low).norm();
}

TEST_P(RealDataset, OpensByItsFolderAlone) {
  const RealCase& c = GetParam();
  const fs::path folder = RealData(c.folder);
  if (folder.empty()) GTEST_SKIP() << "no recording '" << c.folder << "' (set LIVEMVS_DATA)";
  const std::unique_ptr<Dataset> dataset = Open(folder);
  EXPECT_THAT(dataset->description(), HasSubstr(c.description));
  ASSERT_THAT(dataset->views(), SizeIs(c.views));
  const Camera& camera = dataset->views()[0].camera;
  EXPECT_NEAR(camera.fx, c.fx, 1e-3);
  EXPECT_NEAR(camera.cx, c.cx, 1e-3);
  const double extent = ExtentOfPath(*dataset);
  EXPECT_GT(extent, c.extent_min);
  EXPECT_LT(extent, c.extent_max);
  for (std::size_t i = 1; i < dataset->views().size(); ++i) {
    EXPECT_GT(dataset->views()[i].index, dataset->views()[i - 1].index);
    EXPECT_GT(dataset->views()[i].timestamp, dataset->views()[i - 1].timestamp);
  }
  const std::optional<PosedFrame> frame = dataset->Next();
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->picture->width(), c.width);
  EXPECT_EQ(frame->picture->height(), c.height);
  int low = 255, high = 0;
  for (int x = 0; x < c.width; ++x) {
    low = std::min<int>(low, frame->picture->grey(x, c.height / 2));
    high = std::max<int>(high, frame->picture->grey(x, c.height / 2));
  }
  EXPECT_GT(high - low, 30) << "the first picture is blank";
}

INSTANTIATE_TEST_SUITE_P(
    Folders,
    RealDataset,
    ::testing::Values(
        RealCase{"cube", 218, 640, 480, "COLMAP text", 809.037, 319.5, 0.3, 1.5},
        RealCase{"redkitchen", 400, 640, 480, "transforms.json", 522.3308, 320, 0.5, 6},
        RealCase{"temple-ring", 47, 640, 480, "Middlebury", 1520.4, 302.32, 0.5, 2},
        RealCase{"fox", 50, 1080, 1920, "transforms.json", 1375.52, 554.058, 2, 20},
        RealCase{"tsukuba", 150, 640, 480, "TUM", 615, 320, 0.5, 1000},
        RealCase{"cube-dots", 80, 384, 288, "list of cameras", 604.27951, 192, 0.05, 5},
        RealCase{"board-orbit", 240, 960, 720, "poses by frame", 912, 479.5, 0.5, 2}),
    [](const auto& param) {
      std::string name = param.param.folder;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

TEST(RealDatasetTest, SparsePointsOfTheCubeProjectIntoTheImages) {
  const fs::path folder = RealData("cube");
  if (folder.empty()) GTEST_SKIP() << "no recording 'cube' (set LIVEMVS_DATA)";
  LogCatcher log;
  const std::unique_ptr<Dataset> dataset = Open(folder);
  // The folder also holds poses.txt; the model has the distortion and comes first.
  EXPECT_THAT(log.infos(), ::testing::Contains(HasSubstr("using the COLMAP model")));
  ASSERT_GT(dataset->sparse_points().size(), 100u);
  std::size_t seen = 0, all = 0;
  for (const DatasetView& view : dataset->views()) {
    const Projector projector(view.camera);
    for (const Eigen::Vector3d& point : dataset->sparse_points()) {
      const auto pixel = projector.Project(view.cam_from_world * point);
      seen += pixel && view.camera.Contains(*pixel) ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GT(static_cast<double>(seen) / static_cast<double>(all), 0.8);
}

TEST(RealDatasetTest, MissingImagesOfTheFoxAreCountedInOneWarning) {
  const fs::path folder = RealData("fox");
  if (folder.empty()) GTEST_SKIP() << "no recording 'fox' (set LIVEMVS_DATA)";
  LogCatcher log;
  const std::unique_ptr<Dataset> dataset = Open(folder);
  ASSERT_THAT(log.warnings(), SizeIs(1));
  EXPECT_THAT(log.warnings()[0], HasSubstr("17 of 67 images"));
  EXPECT_EQ(dataset->statistics().skipped, 17);
}

TEST(RealDatasetTest, BoxOfTheTemple) {
  const fs::path folder = RealData("temple-ring");
  if (folder.empty()) GTEST_SKIP() << "no recording 'temple-ring' (set LIVEMVS_DATA)";
  const std::optional<Box> box = Open(folder)->box();
  ASSERT_TRUE(box.has_value());
  EXPECT_EQ(box->min, Eigen::Vector3d(-0.023121, -0.038009, -0.091940));
  EXPECT_EQ(box->max, Eigen::Vector3d(0.078626, 0.121636, -0.017395));
}

TEST(RealDatasetTest, PhotosWithoutPosesSayWhatIsMissing) {
  const fs::path folder = RealData("board-photos/opencv_aruco_calibration");
  if (folder.empty()) GTEST_SKIP() << "no recording 'board-photos' (set LIVEMVS_DATA)";
  EXPECT_THAT(OpenError(folder), HasSubstr("--poses"));
  EXPECT_THAT(OpenError(RealData("board-photos")), HasSubstr("Supported are"));
}

}  // namespace
}  // namespace livemvs
