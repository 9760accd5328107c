#pragma once

#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

struct RegularisationOptions {
  /// Neighbours of a point are sought within this many of its footprints, ...
  float radius_px = 5;
  /// ... and the nearest of these count, itself included.
  int neighbors = 16;
  /// A point has support if at least this many of its neighbours, itself included, lie on one plane
  /// with it, within their standard deviations; 0: all have.
  int min_support = 4;

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// Light regularisation of a cloud of independent estimates, by the assumption that surfaces are
/// smooth over a few pixels. To the neighbours of each point a plane is fitted, weighted by their
/// variances and robustly, so that an edge or an outlier does not bend it. The point moves towards
/// the plane, at most by its own standard deviation; one that finds no others on a plane with it is
/// marked. Works on points that know their sigma and footprint; others stay as they are.
/// Multi-threaded; the result does not depend on the number of threads.
///
/// Differs from [VH11], which regularises nothing: noise of independent seeds averages out where
/// they share a surface, and lonely points are mostly wrong ones (docs/ablation.md).
/// @return A mark for each point, 1 for those without support.
[[nodiscard]] std::vector<char> Regularise(const RegularisationOptions& options, PointCloud* cloud);

}  // namespace livemvs
