#include "livemvs/tracking/corner_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>

#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/film.h"
#include "livemvs/tracking/opencv_dictionary.h"

namespace livemvs {
namespace {

using Eigen::Vector2d;

// Of a rendered corner, 2 grey levels of noise included [px].
constexpr double kCornerRms = 0.05;
// Of their mean: light that falls off to one side shifts them all a little [px].
constexpr double kCornerMean = 0.025;
// What OpenCV 4.6 adds to both coordinates of an interpolated corner [px].
constexpr double kOpenCvShift = 0.5;

FilmOptions CornerFilm() {
  FilmOptions film;
  film.camera = SyntheticCamera(960, 720);
  film.path.radius = 0.42;
  film.path.height = 0.36;
  film.noise_sigma = 2;
  return film;
}

struct Errors {
  int n = 0;
  Vector2d mean = Vector2d::Zero();
  double rms = 0;
};

Errors ErrorsOf(const std::vector<FoundCorner>& found,
                const Film& film,
                const FilmOptions& options,
                int frame) {
  const Projector projector(options.camera);
  const std::vector<BoardCorner> corners = CornersOf(options.board);
  Errors e;
  for (const FoundCorner& corner : found) {
    const auto truth = projector.Project(film.PoseAt(frame) * corners[corner.index].point);
    const Vector2d error = corner.fit.pixel - truth.value();
    e.mean += error;
    e.rms += error.squaredNorm();
    ++e.n;
  }
  e.mean /= std::max(1, e.n);
  e.rms = std::sqrt(e.rms / std::max(1, e.n));
  return e;
}

std::vector<FoundCorner> FindByMarkers(const FilmOptions& options,
                                       const Image<std::uint8_t>& grey) {
  MarkerDetector detector(options.board, 2000);
  const CornerSearch search(options.board);
  return search.FindByMarkers(grey.view(), detector.Detect(grey.view()), {});
}

TEST(CornerSearchTest, CornersAreWithinATwentiethOfAPixel) {
  const FilmOptions options = CornerFilm();
  const Film film(options);
  const FilmFrame frame = film.Frame(7);
  const Errors e = ErrorsOf(FindByMarkers(options, frame.picture.grey), film, options, 7);
  EXPECT_EQ(e.n, frame.visible_corners);
  EXPECT_LT(e.rms, kCornerRms);
  EXPECT_LT(e.mean.norm(), kCornerMean);
}

// The trap: what OpenCV 4.6 gives as corners of a ChArUco board is half a pixel off.
TEST(CornerSearchTest, DoesNotShareTheShiftOfOpenCv) {
  const FilmOptions options = CornerFilm();
  const Film film(options);
  const FilmFrame frame = film.Frame(7);
  const Image<std::uint8_t>& grey = frame.picture.grey;
  const cv::Mat mat(grey.height(),
                    grey.width(),
                    CV_8UC1,
                    const_cast<std::uint8_t*>(grey.Row(0)),
                    static_cast<std::size_t>(grey.stride()));
  const auto board = cv::aruco::CharucoBoard::create(
      12, 8, 0.035F, 0.026F, OpenCvDictionary(options.board.dictionary));
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(mat, board->dictionary, markers, ids);
  cv::Mat corners, corner_ids;
  cv::aruco::interpolateCornersCharuco(markers, ids, mat, board, corners, corner_ids);
  std::vector<FoundCorner> theirs;
  for (int i = 0; i < corners.rows; ++i) {
    const auto p = corners.at<cv::Point2f>(i);
    FoundCorner corner;
    corner.index = corner_ids.at<int>(i);
    corner.fit.pixel = {p.x, p.y};
    theirs.push_back(corner);
  }
  const Errors e = ErrorsOf(theirs, film, options, 7);
  ASSERT_GT(e.n, 40);
  EXPECT_NEAR(e.mean.x(), kOpenCvShift, 0.1);
  EXPECT_NEAR(e.mean.y(), kOpenCvShift, 0.1);
  EXPECT_LT(ErrorsOf(FindByMarkers(options, grey), film, options, 7).mean.norm(), kCornerMean);
}

TEST(CornerSearchTest, HiddenCornersAreNotFound) {
  FilmOptions options = CornerFilm();
  options.hidden = 0.4;
  options.decoys = true;
  const Film film(options);
  const FilmFrame frame = film.Frame(3);
  ASSERT_LT(frame.visible_corners, 0.75 * frame.corners_in_view);
  const CornerSearch search(options.board);
  const auto views = search.ViewsFromPose(Projector(options.camera), frame.cam_from_world);
  const auto found = search.Find(frame.picture.grey.view(), views, {});
  EXPECT_GT(static_cast<double>(found.size()), 0.7 * frame.visible_corners);
  // A corner of the discs' own chequer may stand in for one that is hidden, but few.
  int wrong = 0;
  for (const FoundCorner& corner : found) {
    wrong += ErrorsOf({corner}, film, options, 3).rms > 0.3 ? 1 : 0;
  }
  EXPECT_LE(wrong, 2);
}

TEST(CornerSearchTest, FindsNothingInAnEmptyPicture) {
  const FilmOptions options = CornerFilm();
  const Film film(options);
  const Image<std::uint8_t> black(960, 720);
  const CornerSearch search(options.board);
  const auto views = search.ViewsFromPose(Projector(options.camera), film.PoseAt(0));
  EXPECT_TRUE(search.Find(black.view(), views, {}).empty());
  EXPECT_TRUE(FindByMarkers(options, black).empty());
  EXPECT_TRUE(search.Find(Image<std::uint8_t>(8, 8).view(), views, {}).empty());
}

TEST(HomographyTest, MapsWhatItWasMadeFrom) {
  Eigen::Matrix3d h;
  h << 900, 40, 300, -30, 850, 200, 0.4, -0.3, 1;
  std::vector<Vector2d> points, pixels;
  for (int i = 0; i < 7; ++i) {
    points.emplace_back(0.05 * i, 0.03 * (i * i % 5));
    pixels.emplace_back((h * points.back().homogeneous()).hnormalized());
  }
  const auto fitted = FitHomography(points, pixels);
  ASSERT_TRUE(fitted.has_value());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT(((*fitted * points[i].homogeneous()).hnormalized() - pixels[i]).norm(), 1e-6);
  }
  for (Vector2d& p : points) p.y() = 2 * p.x();
  EXPECT_FALSE(FitHomography(points, pixels).has_value());
}

}  // namespace
}  // namespace livemvs
