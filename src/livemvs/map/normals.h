#pragma once

#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

/// Replaces the normal of each point by that of the plane through its k nearest points (the
/// direction in which they spread least), on the side of the normal that the point came with: a
/// converged point comes with the direction towards the camera that saw it. A point without a
/// plane - fewer than 5 points near it, all on one line or in one place, not finite - keeps the
/// normal it has. "Near" is within 10 times the median distance of the k-th neighbours.
/// Multi-threaded; the result does not depend on the number of threads.
/// @param k  Points of a neighbourhood, itself included, >= 5.
/// @throws std::invalid_argument where k is smaller.
void EstimateNormals(PointCloud& cloud, int k = 16);

/// Distance of each point to its k-th nearest other point [scene], by which a renderer chooses the
/// size of a point; at most 1.5 times the lower quartile of those points' own, so that a lonely
/// point beside a surface does not become large. Infinite where there are fewer points; 0 for a
/// point that is not finite.
std::vector<float> PointSpacing(const PointCloud& cloud, int k = 4);

}  // namespace livemvs
