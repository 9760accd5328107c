#pragma once

#include "livemvs/core/point.h"

namespace livemvs::reference {

/// The widest angle that others leave free around a point of a cloud, all of which are looked at;
/// 0 where they are too sparse. See FindRims() [radians].
double WidestGap(const PointCloud& cloud, std::size_t point, double radius_px);

}  // namespace livemvs::reference
