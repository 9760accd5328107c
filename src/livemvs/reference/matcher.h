#pragma once

#include "livemvs/reference/algorithm1.h"

namespace livemvs::reference {

/// Distance along the seed's unit bearing at the coordinate mu of its interval [scene].
double DepthAt(const Options& options, const Seed& seed, double mu);

}  // namespace livemvs::reference
