#pragma once

#include "livemvs/core/point.h"

namespace livemvs::reference {

/// How many of all the points of a cloud agree with one of them that leans, see FindOverhanging().
int Supporters(const PointCloud& cloud, std::size_t point, double reach_px);

}  // namespace livemvs::reference
