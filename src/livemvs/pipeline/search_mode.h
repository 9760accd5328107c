#pragma once

#include <vector>

#include "livemvs/core/options.h"
#include "livemvs/core/scene_range.h"

namespace livemvs {

/// The median over neighbouring frames of the length [px] of the stretch of epipolar line on which
/// the range's depths lie, at the picture's centre. 0 for fewer than two frames.
double MedianDisparityRange(const std::vector<PosedCamera>& cameras, const SceneRange& range);

/// Settles Search::kAuto for these frames: kWindow if the largest window covers what the steps
/// between frames need, else kFull; and fits the options to it. Seeds of kFull meet few frames, so
/// the prior weighs less and failures condemn sooner.
Options ResolveSearch(const std::vector<PosedCamera>& cameras,
                      const SceneRange& range,
                      const Options& options);

}  // namespace livemvs
