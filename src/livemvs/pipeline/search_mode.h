#pragma once

#include <vector>

#include "livemvs/core/options.h"
#include "livemvs/pipeline/scene_range.h"

namespace livemvs {

/// The median over neighbouring frames of the length [px] of the stretch of epipolar line on which the
/// range's depths lie, at the picture's centre. 0 for fewer than two frames.
double MedianDisparityRange(const std::vector<CameraPose>& cameras, const SceneRange& range);

/// What Search::kAuto means for these frames: kWindow if the largest window covers the prior's first
/// projection, else kFull. Any other setting is returned as it is.
Search ChooseSearch(const std::vector<CameraPose>& cameras,
                    const SceneRange& range,
                    const Options& options);

}  // namespace livemvs
