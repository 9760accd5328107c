#pragma once

#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/pose.h"
#include "livemvs/tracking/pose_source.h"

namespace livemvs {

/// How far estimates are from the truth, over a sequence.
class TrackScore {
 public:
  /// A frame that shows so many corners can be tracked.
  static constexpr int kEnoughCorners = 12;

  /// @param room  Its points are projected with the true and the estimated pose.
  explicit TrackScore(const Box& room) : room_(room) {}

  /// @param visible_corners  As far as is known; -1: enough.
  void Add(const PoseEstimate& estimate,
           const Camera& camera,
           const Rigid3d& truth,
           int visible_corners = -1);

  int frames() const { return frames_; }
  int tracked() const { return tracked_; }
  int trackable() const { return trackable_; }  ///< Frames that show enough corners.
  int missed() const { return missed_; }        ///< Of these, those without a pose.
  int wrong() const { return wrong_; }          ///< Poses that are off by more than 2 px rms.
  double center_rms() const;                    ///< [m]
  double pixel_rms() const;                     ///< Over all points and frames [px].
  double worst_pixel() const { return worst_pixel_; }  ///< Largest rms of a frame [px].
  double last_center() const { return last_center_; }  ///< Of the last tracked frame [m].
  double last_pixel() const { return last_pixel_; }    ///< Likewise its rms [px].
  std::string Summary() const;

 private:
  Box room_;
  int frames_ = 0, tracked_ = 0, trackable_ = 0, missed_ = 0, wrong_ = 0;
  double center_squares_ = 0, pixel_squares_ = 0, worst_pixel_ = 0;
  double last_center_ = 0, last_pixel_ = 0;
};

}  // namespace livemvs
