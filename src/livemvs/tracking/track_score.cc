#include "livemvs/tracking/track_score.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace livemvs {
namespace {

constexpr int kSteps = 4;         // of a grid over the room
constexpr double kWrongPx = 2;    // a pose that is off by more is wrong
constexpr double kLostPx = 1000;  // error of a point that the estimate does not see at all

}  // namespace

void TrackScore::Add(const PoseEstimate& estimate,
                     const Camera& camera,
                     const Rigid3d& truth,
                     int visible_corners) {
  ++frames_;
  const bool enough = visible_corners < 0 || visible_corners >= kEnoughCorners;
  trackable_ += enough ? 1 : 0;
  missed_ += enough && !estimate.cam_from_world ? 1 : 0;
  if (!estimate.cam_from_world) return;
  ++tracked_;
  const Projector projector(camera);
  double squares = 0;
  int n = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Array3d part =
        Eigen::Array3i(i % kSteps, i / kSteps % kSteps, i / (kSteps * kSteps)).cast<double>();
    const Eigen::Vector3d point =
        room_.min + ((room_.max - room_.min).array() * part / (kSteps - 1)).matrix();
    const auto expected = projector.Project(truth * point);
    if (!expected || !camera.Contains(*expected)) continue;
    const auto seen = projector.Project(*estimate.cam_from_world * point);
    squares += seen ? (*seen - *expected).squaredNorm() : kLostPx * kLostPx;
    ++n;
  }
  last_pixel_ = std::sqrt(squares / std::max(1, n));
  last_center_ = (estimate.cam_from_world->Center() - truth.Center()).norm();
  wrong_ += last_pixel_ > kWrongPx ? 1 : 0;
  worst_pixel_ = std::max(worst_pixel_, last_pixel_);
  pixel_squares_ += last_pixel_ * last_pixel_;
  center_squares_ += last_center_ * last_center_;
}

double TrackScore::center_rms() const { return std::sqrt(center_squares_ / std::max(1, tracked_)); }

double TrackScore::pixel_rms() const { return std::sqrt(pixel_squares_ / std::max(1, tracked_)); }

std::string TrackScore::Summary() const {
  char text[200];
  std::snprintf(
      text,
      sizeof text,
      "%d poses, %d of %d trackable frames missed, %d wrong; centres %.3f mm rms, room %.3f px "
      "rms, worst frame %.3f px",
      tracked_,
      missed_,
      trackable_,
      wrong_,
      1e3 * center_rms(),
      pixel_rms(),
      worst_pixel_);
  return text;
}

}  // namespace livemvs
