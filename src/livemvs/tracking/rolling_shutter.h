#pragma once

#include <optional>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"
#include "livemvs/tracking/pose_fit.h"

namespace livemvs {

/// Watches for a rolling shutter: rows that are read one after the other see the board from poses
/// between those of the frames, which moves corners by ρ (row / height - 1/2) v, v their motion
/// from frame to frame. What a pose of its own cannot take up of that stays in the residuals, and
/// tells ρ, the part of a frame's time from the first row to the last.
class RollingShutterWatch {
 public:
  /// @param pose      Of a frame, and what it rests on.
  /// @param previous  The pose of the frame before.
  void Add(const Camera& camera,
           const PoseFit& pose,
           const std::vector<PointObservation>& observations,
           const Rigid3d& previous);

  /// ρ, where the frames so far leave no doubt that it is not zero.
  std::optional<double> Readout() const;

 private:
  double weighted_ = 0, weights_ = 0, squares_ = 0;
  long count_ = 0;  // of residuals' coordinates
};

}  // namespace livemvs
