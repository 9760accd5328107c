#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/posed_camera.h"

namespace livemvs {

/// Where surfaces are wanted: in a box, or between two depths, or both. [scene]
struct SceneRange {
  std::optional<Box> box;  ///< World. FinishCloud() drops the points outside of it.
  double near = 0;         ///< Least planar depth.
  double far = 0;          ///< Largest planar depth.
  std::string origin;      ///< For people: where the range comes from.

  /// @throws std::invalid_argument where the range is empty or not finite.
  void Check() const;

  /// Where surfaces are sought: somewhat beyond the box, so that points at its sides have
  /// neighbours and the rays to them do not end there.
  std::optional<Box> SoughtBox() const;

  /// The stretch of a ray [near, far] in distances along the unit bearing, or nothing where it
  /// misses.
  /// @param center     Camera centre in the world.
  /// @param direction  Unit direction in the world.
  /// @param cosine     Of the angle between the ray and the optical axis.
  std::optional<std::pair<double, double>> Along(const Eigen::Vector3d& center,
                                                 const Eigen::Vector3d& direction,
                                                 double cosine) const;
};

/// The range of a box: depths between the nearest and the farthest corner from any camera.
SceneRange RangeOfBox(const Box& box, const std::vector<PosedCamera>& cameras);

/// A range from what is known before the first picture: of the sparse points, where there are
/// enough seen by the cameras; else of the region that the cameras look at; else, for cameras that
/// look at nothing in common (forward motion, a walk through rooms), from the length of their path.
/// @throws Error (kBadInput) where the cameras do not move.
SceneRange DeriveRange(const std::vector<PosedCamera>& cameras,
                       const std::vector<Eigen::Vector3d>& sparse_points);

}  // namespace livemvs
