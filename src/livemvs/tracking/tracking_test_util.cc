#include "livemvs/tracking/tracking_test_util.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace livemvs::testing_tracking {

std::filesystem::path RealData(const std::string& name) {
  const char* variable = std::getenv("LIVEMVS_DATA");
  const std::filesystem::path base =
      variable != nullptr && *variable != '\0'
          ? std::filesystem::path(variable)
          : std::filesystem::path(LIVEMVS_SOURCE_DIR) / "../shared/data";
  return std::filesystem::is_directory(base / name) ? base / name : std::filesystem::path();
}

void TrackScore::Add(const PoseEstimate& estimate,
                     const Camera& camera,
                     const Rigid3d& truth,
                     const Box& room) {
  ++frames_;
  if (!estimate.cam_from_world) return;
  ++tracked_;
  const Projector projector(camera);
  constexpr int kSteps = 4;  // of a grid over the room
  double squares = 0;
  int n = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Vector3d part(i % kSteps, i / kSteps % kSteps, i / (kSteps * kSteps));
    const Eigen::Vector3d point =
        room.min + ((room.max - room.min).array() * part.array() / (kSteps - 1)).matrix();
    const auto expected = projector.Project(truth * point);
    if (!expected || !camera.Contains(*expected)) continue;
    const auto seen = projector.Project(*estimate.cam_from_world * point);
    squares += seen ? (*seen - *expected).squaredNorm() : 1e6;
    ++n;
  }
  last_pixel_ = std::sqrt(squares / std::max(1, n));
  last_center_ = (estimate.cam_from_world->Center() - truth.Center()).norm();
  worst_pixel_ = std::max(worst_pixel_, last_pixel_);
  pixel_squares_ += last_pixel_ * last_pixel_;
  center_squares_ += last_center_ * last_center_;
}

double TrackScore::center_rms() const { return std::sqrt(center_squares_ / std::max(1, tracked_)); }

double TrackScore::pixel_rms() const { return std::sqrt(pixel_squares_ / std::max(1, tracked_)); }

std::string TrackScore::Summary() const {
  char text[200];
  std::snprintf(text,
                sizeof text,
                "tracked %d of %d, centres %.3f mm rms, room %.3f px rms, worst frame %.3f px",
                tracked_,
                frames_,
                1e3 * center_rms(),
                pixel_rms(),
                worst_pixel_);
  return text;
}

}  // namespace livemvs::testing_tracking
