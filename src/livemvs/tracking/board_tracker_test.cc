#include "livemvs/tracking/board_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/film.h"
#include "livemvs/tracking/motion.h"
#include "livemvs/tracking/track_score.h"

namespace livemvs {
namespace {

constexpr double kMaxHardRms = 0.1;  // [px], under all conditions together at 640 x 480

FilmOptions SomeFilm() {
  FilmOptions film;
  film.camera = SyntheticCamera(640, 480);
  film.path.target = {0, 0, 0.02};
  film.path.radius = 0.42;
  film.path.height = 0.36;
  film.noise_sigma = 2;
  return film;
}

FilmOptions Hard() {
  FilmOptions film = SomeFilm();
  film.camera.model = CameraModel::kBrownConrady;
  film.camera.distortion = {-0.25, 0.08, 0.001, -0.0005};
  film.noise_sigma = 4;
  film.shutter = 0.5;
  film.hidden = 0.3;
  film.decoys = true;
  return film;
}

TEST(BoardTrackerTest, FollowsThroughDistortionBlurNoiseAndThingsOnTheBoard) {
  const FilmOptions options = Hard();
  const Film film(options);
  const auto tracker = MakeBoardTracker(options.board, options.camera);
  TrackScore score(BoxAbove(options.board, 0.12));
  for (int i = 0; i < 40; ++i) {
    const FilmFrame frame = film.Frame(i);
    const PoseEstimate e = tracker->Estimate(frame.picture, i / 30.0);
    score.Add(e, options.camera, frame.cam_from_world, frame.visible_corners);
    EXPECT_EQ(e.state, TrackingState::kTracking) << i << ": " << e.problem;
  }
  EXPECT_EQ(score.missed(), 0);
  EXPECT_EQ(score.wrong(), 0);
  EXPECT_LT(score.pixel_rms(), kMaxHardRms) << score.Summary();
}

TEST(BoardTrackerTest, IsLostAndFoundInTheFirstPictureThatShowsTheBoard) {
  FilmOptions options = SomeFilm();
  const Film film(options);
  const auto tracker = MakeBoardTracker(options.board, options.camera);
  Picture grey;
  grey.grey = Image<std::uint8_t>(640, 480);
  EXPECT_EQ(tracker->Estimate(grey, 0).state, TrackingState::kSearching);
  EXPECT_EQ(tracker->Estimate(grey, 0.03).problem, "board not seen");
  EXPECT_TRUE(tracker->Estimate(film.Frame(3).picture, 0.1).cam_from_world);
  const PoseEstimate lost = tracker->Estimate(grey, 0.13);
  EXPECT_EQ(lost.state, TrackingState::kLost);
  EXPECT_FALSE(lost.cam_from_world);
  // From another side, a second later: the prediction is worth nothing.
  const FilmFrame again = film.Frame(90);
  const PoseEstimate found = tracker->Estimate(again.picture, 1.2);
  ASSERT_TRUE(found.cam_from_world);
  EXPECT_LT((found.cam_from_world->Center() - again.cam_from_world.Center()).norm(), 1e-3);
  // Time that stands still or runs backwards does not matter either.
  EXPECT_TRUE(tracker->Estimate(again.picture, 1.2).cam_from_world);
  EXPECT_TRUE(tracker->Estimate(film.Frame(20).picture, 0.5).cam_from_world);
}

TEST(BoardTrackerTest, AnotherBoardIsNoBoard) {
  FilmOptions options = SomeFilm();
  options.board.first_id = 100;
  const Film film(options);
  Board expected = options.board;
  expected.first_id = 0;
  const auto tracker = MakeBoardTracker(expected, options.camera);
  for (int i = 0; i < 5; ++i) {
    const PoseEstimate e = tracker->Estimate(film.Frame(i).picture, i / 30.0);
    EXPECT_FALSE(e.cam_from_world);
    EXPECT_FALSE(e.problem.empty());
  }
}

TEST(BoardTrackerTest, AWrongCalibrationIsSaid) {
  FilmOptions options = SomeFilm();
  const Film film(options);
  Camera wrong = options.camera;
  wrong.model = CameraModel::kBrownConrady;
  wrong.distortion = {0.6, 0.5};
  const auto tracker = MakeBoardTracker(options.board, wrong);
  const PoseEstimate e = tracker->Estimate(film.Frame(0).picture, 0);
  EXPECT_FALSE(e.cam_from_world);
  EXPECT_FALSE(e.problem.empty());
}

TEST(BoardTrackerTest, CalibratesItselfWithinOnePercent) {
  FilmOptions options = SomeFilm();
  options.camera.model = CameraModel::kBrownConrady;
  options.camera.distortion = {-0.1, 0.02};
  options.samples = 4;
  const Film film(options);
  const auto tracker = MakeBoardTracker(options.board, std::nullopt);
  int tracked = 0;
  for (int i = 0; i < 40; ++i) {
    const PoseEstimate e = tracker->Estimate(film.Frame(6 * i).picture, i / 5.0);
    tracked += e.cam_from_world ? 1 : 0;
    EXPECT_TRUE(e.cam_from_world || e.problem.find("calibrat") != std::string::npos) << e.problem;
  }
  EXPECT_GT(tracked, 20);
  EXPECT_NEAR(tracker->camera().fx, options.camera.fx, 0.01 * options.camera.fx);
}

double ReadoutOf(double readout) {
  FilmOptions options = SomeFilm();
  options.path.wobble = 2;
  options.readout = readout;
  options.samples = 4;
  const Film film(options);
  const auto tracker = MakeBoardTracker(options.board, options.camera);
  double found = 0;
  for (int i = 0; i < 40; ++i) {
    found = tracker->Estimate(film.Frame(i).picture, i / 30.0).rolling_readout;
  }
  return found;
}

TEST(BoardTrackerTest, SuspectsARollingShutterWhereThereIsOne) {
  EXPECT_EQ(ReadoutOf(0), 0);
  EXPECT_NEAR(ReadoutOf(0.6), 0.6, 0.15);
}

TEST(BoardTrackerTest, ImprovesAGivenCalibrationOverKeyFrames) {
  FilmOptions options = SomeFilm();
  options.samples = 4;
  const Film film(options);
  Camera given = options.camera;
  given.fx = given.fy = 1.02 * options.camera.fx;
  TrackerOptions tracking;
  tracking.refine_camera = true;
  tracking.refine_sheet = true;
  const auto tracker = MakeBoardTracker(options.board, given, tracking);
  for (int i = 0; i < 50; ++i) tracker->Estimate(film.Frame(5 * i).picture, i / 6.0);
  EXPECT_NEAR(tracker->camera().fx, options.camera.fx, 0.005 * options.camera.fx);
}

TEST(BoardTrackerTest, ArgumentsAreChecked) {
  Camera camera = SyntheticCamera(640, 480);
  Board board;
  board.rows = 1;
  EXPECT_THROW(MakeBoardTracker(board, camera), std::invalid_argument);
  camera.fx = std::nan("");
  EXPECT_THROW(MakeBoardTracker(Board(), camera), std::invalid_argument);
  TrackerOptions options;
  options.min_corners = 1;
  EXPECT_THROW(MakeBoardTracker(Board(), SyntheticCamera(640, 480), options),
               std::invalid_argument);
  const auto tracker = MakeBoardTracker(Board(), SyntheticCamera(640, 480));
  Picture other;
  other.grey = Image<std::uint8_t>(320, 240);
  EXPECT_THROW(tracker->Estimate(other, 0), std::invalid_argument);
  EXPECT_THROW(tracker->Estimate(Picture(), 0), std::invalid_argument);
}

TEST(MotionTest, GoesOnAsItDid) {
  FilmOptions options = SomeFilm();
  options.path.wobble = 0;
  Motion motion;
  EXPECT_FALSE(motion.Predict(0, 1));
  motion.Add(0, PoseAt(options.path, 0));
  EXPECT_TRUE(motion.Predict(0.01, 1));
  motion.Add(1 / 30.0, PoseAt(options.path, 1));
  const auto predicted = motion.Predict(2 / 30.0, 1);
  ASSERT_TRUE(predicted);
  // An even orbit is an even motion.
  EXPECT_LT((predicted->Center() - PoseAt(options.path, 2).Center()).norm(), 2e-4);
  EXPECT_FALSE(motion.Predict(5, 1)) << "too long ago";
  EXPECT_FALSE(motion.Predict(0, 1)) << "before";
  EXPECT_FALSE(motion.Predict(std::nan(""), 1));
}

}  // namespace
}  // namespace livemvs
