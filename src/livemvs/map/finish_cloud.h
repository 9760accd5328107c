#pragma once

#include <cstddef>

#include "livemvs/core/options.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// Points that FinishCloud() took out.
struct FinishedCloud {
  std::size_t superseded = 0;   ///< Coarse ones that finer ones stand for.
  std::size_t unsupported = 0;  ///< Ones that too few neighbours agree with.
};

/// What is done to the points of a Reconstructor once all frames are in: RemoveSuperseded() where
/// there are several levels, and Regularise() where the options ask for it.
FinishedCloud FinishCloud(const Options& options, PointCloud* cloud);

}  // namespace livemvs
