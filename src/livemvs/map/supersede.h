#pragma once

#include <optional>
#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

/// Marks, with 1, the points that finer ones stand for: those within whose footprint lies a point
/// of a clearly smaller footprint. Where there is a box, finer points outside of it do not stand
/// for those within. A cloud from several levels of an image pyramid that loses them keeps its
/// coarse points only where there are no others. Multi-threaded; the result does not depend on the
/// number of threads.
/// @return A mark for each point.
[[nodiscard]] std::vector<char> FindSuperseded(const std::optional<Box>& box,
                                               const PointCloud& cloud);

}  // namespace livemvs
