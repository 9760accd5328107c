#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "livemvs/core/options.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// What FinishCloud() took out, and what it left.
struct FinishedCloud {
  std::size_t overhanging = 0;      ///< Beyond the last of their surface, see FindOverhanging().
  std::size_t superseded = 0;       ///< Coarse ones that finer ones stand for.
  std::size_t unsupported = 0;      ///< Ones that too few neighbours agree with.
  std::size_t rims = 0;             ///< The outermost of their surface, see FindRims().
  std::size_t outside = 0;          ///< Ones that lie outside of the box.
  std::vector<std::uint32_t> kept;  ///< Of each point left, its place before; ascending.
};

/// What is done to the points of a Reconstructor once all frames are in: FindOverhanging(),
/// FindSuperseded() where there are several levels, Regularise() and FindRims(), where the options
/// ask for them; what they find goes. Where there is a box, only then what lies outside of it goes:
/// it has supported what lies inside.
FinishedCloud FinishCloud(const Options& options, const std::optional<Box>& box, PointCloud* cloud);

}  // namespace livemvs
