#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "livemvs/core/platform.h"
#include "livemvs/core/point.h"
#include "livemvs/core/posed_camera.h"

namespace livemvs {

/// Where surfaces are wanted: in a box, or between two depths, or both. [scene]
struct SceneRange {
  std::optional<Box> box;  ///< World.
  double margin = 0;       ///< How far beyond the box surfaces are sought.
  double near = 0;         ///< Least planar depth.
  double far = 0;          ///< Largest planar depth.
  std::string origin;      ///< For people: where the range comes from.

  /// @throws std::invalid_argument where the range is empty or not finite.
  void Check() const;

  /// Where surfaces are sought: beyond the box by the margin, so that points at its sides have
  /// neighbours and the rays to them do not end there. What lies beyond is dropped at the end, by
  /// FinishCloud().
  std::optional<Box> SoughtBox() const;

  /// The stretch of a ray [near, far] in distances along the unit bearing, in the sought box, or
  /// nothing where it misses.
  /// @param center     Camera centre in the world.
  /// @param direction  Unit direction in the world.
  /// @param cosine     Of the angle between the ray and the optical axis.
  std::optional<std::pair<double, double>> Along(const Eigen::Vector3d& center,
                                                 const Eigen::Vector3d& direction,
                                                 double cosine) const;
};

/// A SceneRange as kernels take it: trivially copyable.
struct RangeBounds {
  double near, far;
  bool boxed;
  double box_min[3], box_max[3];  ///< Of the box that is sought, where it is boxed.
};

RangeBounds BoundsOf(const SceneRange& range);

/// SceneRange::Along() with three numbers per vector; false where the ray misses.
LIVEMVS_DEVICE inline bool ClipRay(const RangeBounds& range,
                                   const double* center,
                                   const double* direction,
                                   double cosine,
                                   double* nearest,
                                   double* farthest) {
  constexpr double kParallel = 1e-12;
  double lo = range.near / cosine;
  double hi = range.far / cosine;
  for (int axis = 0; range.boxed && axis < 3; ++axis) {
    const double d = direction[axis];
    if (std::abs(d) < kParallel) {
      if (center[axis] < range.box_min[axis] || center[axis] > range.box_max[axis]) return false;
      continue;
    }
    const double s0 = (range.box_min[axis] - center[axis]) / d;
    const double s1 = (range.box_max[axis] - center[axis]) / d;
    lo = std::max(lo, std::min(s0, s1));
    hi = std::min(hi, std::max(s0, s1));
  }
  *nearest = lo;
  *farthest = hi;
  return lo < hi;
}

/// The range of a box: depths between the nearest and the farthest corner from any camera.
/// @param margin  See SceneRange, in diagonals of the box.
SceneRange RangeOfBox(const Box& box, double margin, const std::vector<PosedCamera>& cameras);

/// A range from what is known before the first picture: of the sparse points, where there are
/// enough seen by the cameras; else of the region that the cameras look at; else, for cameras that
/// look at nothing in common (forward motion, a walk through rooms), from the length of their path.
/// @throws Error (kBadInput) where the cameras do not move.
SceneRange DeriveRange(const std::vector<PosedCamera>& cameras,
                       const std::vector<Eigen::Vector3d>& sparse_points);

}  // namespace livemvs
