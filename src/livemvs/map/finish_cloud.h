#pragma once

#include <cstddef>
#include <optional>

#include "livemvs/core/options.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// Points that FinishCloud() took out.
struct FinishedCloud {
  std::size_t superseded = 0;   ///< Coarse ones that finer ones stand for.
  std::size_t unsupported = 0;  ///< Ones that too few neighbours agree with.
  std::size_t outside = 0;      ///< Ones that lie outside of the box.
};

/// What is done to the points of a Reconstructor once all frames are in: RemoveSuperseded() where
/// there are several levels, and Regularise() where the options ask for it. Where there is a box,
/// only then what lies outside of it goes: it has supported what lies inside.
FinishedCloud FinishCloud(const Options& options, const std::optional<Box>& box, PointCloud* cloud);

}  // namespace livemvs
