#pragma once

#include <filesystem>
#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/pose.h"
#include "livemvs/tracking/pose_source.h"

namespace livemvs::testing_tracking {

/// A folder of the recordings that tests may use, or an empty path where it is not there.
std::filesystem::path RealData(const std::string& name);

/// How far estimates are from the truth, over a sequence.
class TrackScore {
 public:
  /// @param room  Its points are projected with both poses, where the true one sees them.
  void Add(const PoseEstimate& estimate,
           const Camera& camera,
           const Rigid3d& truth,
           const Box& room);

  int frames() const { return frames_; }
  int tracked() const { return tracked_; }
  double center_rms() const;                           ///< [m]
  double pixel_rms() const;                            ///< Over all points and frames [px].
  double worst_pixel() const { return worst_pixel_; }  ///< Largest rms of a frame [px].
  double last_center() const { return last_center_; }  ///< Of the last tracked frame [m].
  double last_pixel() const { return last_pixel_; }    ///< Likewise its rms [px].
  std::string Summary() const;

 private:
  int frames_ = 0, tracked_ = 0;
  double center_squares_ = 0, pixel_squares_ = 0, worst_pixel_ = 0;
  double last_center_ = 0, last_pixel_ = 0;
};

}  // namespace livemvs::testing_tracking
