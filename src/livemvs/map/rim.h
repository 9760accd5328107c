#pragma once

#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

struct RimOptions {
  /// How far others are sought [px of the finest level].
  float radius_px = 5.25F;

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// Marks, with 1, the points at the rims of surfaces. A patch that reaches over an edge matches
/// where the nearer side of it does, so that things end half a patch too late: the outermost points
/// of a surface are those that may lie on none.
///
/// A point is at a rim if, as the camera saw it, others of its surface leave free more than a third
/// of a turn around it. The others are those that may lie on the same surface, see
/// MayShareSurface(), within radius_px pixels of the finest level, or the nearest eight where these
/// are fewer. Where not even eight are among the nearest 64 points and within four times as far,
/// points are too sparse to tell a rim from a gap between them, and it is none.
///
/// Differs from [VH11], which takes every seed for itself. Multi-threaded; the result does not
/// depend on the number of threads.
/// @return A mark for each point; of those whose uncertainty or line of sight is not known, 0.
[[nodiscard]] std::vector<char> FindRims(const RimOptions& options, const PointCloud& cloud);

}  // namespace livemvs
