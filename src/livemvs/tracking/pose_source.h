#pragma once

#include <optional>
#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/core/frame.h"
#include "livemvs/core/pose.h"

namespace livemvs {

enum class TrackingState {
  kSearching,  ///< Nothing was seen yet.
  kTracking,   ///< The pose is known.
  kLost,       ///< It was known before.
};

/// What a pose source says of one frame.
struct PoseEstimate {
  TrackingState state = TrackingState::kSearching;
  /// Given only where it is good enough for seeds: frames without it are not reconstructed from.
  std::optional<Rigid3d> cam_from_world;
  int observations = 0;  ///< Corners or features that the pose rests on.
  double rms_px = 0;     ///< Of their reprojection.
  /// Expected error of where this pose sees the things to be reconstructed, at the worst place.
  double sigma_px = 0;
  double blur_px = 0;  ///< How far the picture moved during the exposure, as far as is known.
  /// Part of a frame's time from the first row read to the last, where the source is certain that
  /// the shutter rolls: poses are then those of the middle row, and worse when the camera moves.
  double rolling_readout = 0;
  std::string problem;  ///< For people, where there is no pose: "board not seen".
};

/// Says where the camera stood when each picture was taken. Not thread-safe.
class PoseSource {
 public:
  virtual ~PoseSource() = default;

  /// The pose of the next picture. Pictures come in the order of their time stamps [s].
  virtual PoseEstimate Estimate(const Picture& picture, double timestamp) = 0;

  /// The intrinsics as they are known now; a source that calibrates itself improves them.
  virtual Camera camera() const = 0;
};

}  // namespace livemvs
