#pragma once

#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/scene_range.h"

namespace livemvs {

/// A sequence in memory, so that neither decoding nor rendering is measured.
struct BenchSequence {
  std::vector<PosedFrame> frames;
  SceneRange range;
};

/// The data set that the environment variable LIVEMVS_BENCH_DATA names, or else a short orbit round
/// the still life in VGA, which is quick to make. Read once.
const BenchSequence& Sequence();

}  // namespace livemvs
