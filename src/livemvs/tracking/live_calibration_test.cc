#include "livemvs/tracking/live_calibration.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "livemvs/io/camera_source.h"
#include "livemvs/io/fake_v4l2.h"
#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/calibration_guide.h"
#include "livemvs/tracking/film.h"
#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

constexpr int kSize = 480;                  // [px]; square, so that turned pictures fit
constexpr double kFocalError = 0.01;        // of noisy pictures of 480 px
constexpr std::int64_t kMostFrames = 3000;  // ends a test that would go on for ever

CalibrationView See(const Camera& camera, const Rigid3d& pose) {
  const Projector projector(camera);
  CalibrationView view;
  for (const BoardCorner& corner : CornersOf(Board())) {
    const auto pixel = projector.Project(pose * corner.point);
    if (pixel && camera.Contains(*pixel)) view.observations.push_back({corner.point, *pixel, 0.1});
  }
  return view;
}

TEST(CalibrationGuideTest, AsksForSlantsPartsOfThePictureAndMoreViewsInTurn) {
  const Camera camera = SyntheticCamera(640, 480);
  CalibrationGuide guide(640, 480, {});
  EXPECT_NE(guide.Next({}).find("not seen"), std::string::npos);
  const CalibrationView straight = See(camera, LookAt({0, -0.01, 1}, {0, 0, 0}));
  guide.Add(straight);
  EXPECT_NE(guide.Next(straight).find("at a slant: from lower down"), std::string::npos);
  CalibrationView blurred = straight;
  blurred.blur_px = 20;
  EXPECT_NE(guide.Next(blurred).find("more slowly"), std::string::npos);
  guide.Add(See(camera, LookAt({0, -0.8, 0.8}, {0, 0, 0})));
  EXPECT_NE(guide.Missing().find("sideways"), std::string::npos);
  // The camera upright: turned by a quarter about its axis.
  Rigid3d upright = LookAt({0, -0.8, 0.8}, {0, 0, 0});
  const Eigen::Matrix3d quarter{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  upright = Rigid3d{quarter, Eigen::Vector3d::Zero()} * upright;
  guide.Add(See(camera, upright));
  // The sheet does not reach the picture's corners so far away.
  EXPECT_NE(guide.Missing().find("bring the board to the"), std::string::npos);
  for (const double x : {-0.15, 0.15}) {
    for (const double y : {-0.1, 0.1}) {
      guide.Add(See(camera, LookAt({x, y - 0.01, 0.4}, {x, y, 0})));
    }
  }
  EXPECT_NE(guide.Missing().find("5 more views"), std::string::npos) << guide.Missing();
  for (int i = 0; i < 5; ++i) guide.Add(straight);
  EXPECT_EQ(guide.Missing(), "");
}

// As the made-up camera gives them: YUYV.
std::vector<std::string> Pictures(const Camera& camera) {
  std::vector<std::string> pictures;
  for (const Image<std::uint8_t>& grey : FilmFromAllSides(camera)) {
    std::string bytes;
    for (int y = 0; y < grey.height(); ++y) {
      for (int x = 0; x < grey.width(); ++x) {
        bytes += static_cast<char>(grey(x, y));
        bytes += static_cast<char>(128);
      }
    }
    pictures.push_back(std::move(bytes));
  }
  return pictures;
}

TEST(LiveCalibrationTest, CalibratesACameraThatIsUnpluggedMeanwhileAndSaysWhatToFilm) {
  const Camera truth = SyntheticCamera(kSize, kSize);
  FakeV4l2 camera;
  camera.width = camera.height = kSize;
  camera.pictures[V4L2_PIX_FMT_YUYV] = Pictures(truth);
  const auto source = OpenCamera("2", {.mode = ParseMode("480x480:yuyv")}, camera);
  std::set<std::string> prompts;
  std::vector<std::string> news;
  std::string last = "none yet";
  LiveCalibrationWatch watch;
  watch.news = [&](const std::string& text, bool) {
    news.push_back(text);
    const std::lock_guard<std::recursive_mutex> lock(camera.mutex);
    camera.plugged_in = true;
  };
  std::int64_t frames_seen = 0;
  watch.progress = [&](std::int64_t frames, int, const std::string& prompt) {
    prompts.insert(prompt);
    last = prompt;
    frames_seen = frames;
    const std::lock_guard<std::recursive_mutex> lock(camera.mutex);
    if (frames == 5) camera.plugged_in = false;
  };
  watch.stop = [&] { return frames_seen > kMostFrames; };
  const LiveCalibrationResult result = CalibrateLive(source.get(), Board(), {}, watch);
  EXPECT_EQ(result.calibration.problem, "");
  EXPECT_EQ(last, "") << "ends as soon as nothing is missing";
  EXPECT_NEAR(result.calibration.camera.fx, truth.fx, kFocalError * truth.fx);
  EXPECT_NEAR(result.calibration.camera.cx, truth.cx, 0.01 * kSize);
  EXPECT_GT(prompts.size(), 2U);
  ASSERT_GE(news.size(), 2U);
  EXPECT_NE(news[0].find("camera lost"), std::string::npos) << news[0];
  EXPECT_EQ(news[1], "pictures come again");
  EXPECT_FALSE(result.source_lost);
}

TEST(LiveCalibrationTest, EndsWithTheReasonWhereTheCameraDoesNotComeBack) {
  FakeV4l2 camera;
  camera.width = camera.height = kSize;
  camera.pictures[V4L2_PIX_FMT_YUYV] = {std::string(2 * kSize * kSize, 'x')};
  const auto source = OpenCamera("2", {.mode = ParseMode("480x480:yuyv")}, camera);
  LiveCalibrationWatch watch;
  watch.progress = [&](std::int64_t, int, const std::string& prompt) {
    EXPECT_NE(prompt.find("not seen"), std::string::npos);
    const std::lock_guard<std::recursive_mutex> lock(camera.mutex);
    camera.plugged_in = false;
  };
  LiveCalibrationOptions options;
  options.patience = 0.3;
  const LiveCalibrationResult result = CalibrateLive(source.get(), Board(), options, watch);
  EXPECT_TRUE(result.source_lost);
  EXPECT_GE(result.frames, 1);
  EXPECT_EQ(result.with_board, 0);
  EXPECT_NE(result.calibration.problem.find("different views"), std::string::npos);
  options.patience = 0;
  EXPECT_THROW(CalibrateLive(source.get(), Board(), options, watch), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
