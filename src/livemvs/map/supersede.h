#pragma once

#include <cstddef>

#include "livemvs/core/point.h"

namespace livemvs {

/// Removes the points that finer ones stand for: those within whose footprint lies a point of a
/// clearly smaller footprint. A cloud from several levels of an image pyramid thus keeps its coarse
/// points only where there are no others. The order of the rest is kept. Multi-threaded; the result
/// does not depend on the number of threads.
/// @return How many were removed.
std::size_t RemoveSuperseded(PointCloud* cloud);

}  // namespace livemvs
