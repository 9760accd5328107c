#pragma once

#include <optional>

#include "livemvs/core/pose.h"

namespace livemvs {

/// Where a camera that moves on as it did will be.
class Motion {
 public:
  void Add(double time, const Rigid3d& cam_from_world);

  /// The last pose, where it is no more than `max_gap` before a time. [s]
  std::optional<Rigid3d> Last(double time, double max_gap) const;

  /// The pose at a time [s] after the last one, or nothing where that is more than `max_gap` away
  /// or before it.
  std::optional<Rigid3d> Predict(double time, double max_gap) const;

 private:
  struct Known {
    double time;
    Rigid3d pose;
  };
  std::optional<Known> before_, last_;
};

}  // namespace livemvs
