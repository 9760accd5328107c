#pragma once

#include <cstddef>
#include <optional>

#include "livemvs/core/point.h"

namespace livemvs {

/// Removes the points that finer ones stand for: those within whose footprint lies a point of a
/// clearly smaller footprint. Where there is a box, finer points outside of it do not stand for
/// those within. A cloud from several levels of an image pyramid thus keeps its coarse
/// points only where there are no others. The order of the rest is kept. Multi-threaded; the result
/// does not depend on the number of threads.
/// @return How many were removed.
std::size_t RemoveSuperseded(const std::optional<Box>& box, PointCloud* cloud);

}  // namespace livemvs
