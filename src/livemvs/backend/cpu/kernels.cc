// Compiled once per instruction set, with LIVEMVS_TARGET naming it. All that is not a template of
// core's lives in the namespace of that set, so that the linker cannot mix the copies.

#include "livemvs/backend/cpu/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>

#include "livemvs/core/texture.h"

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace livemvs {
namespace LIVEMVS_TARGET {
namespace {

// Each needs those before it.
#if defined(LIVEMVS_SINGLE_LANE)
#include "livemvs/backend/kernel/single_lane.inc"
#else
#include "livemvs/backend/cpu/lanes.inc"

#include "livemvs/backend/cpu/memory.inc"

#include "livemvs/backend/cpu/words.inc"
#endif

#include "livemvs/backend/kernel/matcher.inc"

#include "livemvs/backend/kernel/block.inc"

#include "livemvs/backend/cpu/search_order.inc"

#include "livemvs/backend/kernel/prepare.inc"

#include "livemvs/backend/kernel/search.inc"

#include "livemvs/backend/kernel/finish.inc"

#include "livemvs/backend/kernel/mark.inc"

/// Updates seeds [begin, end), kBlock at most, and counts them by status.
template <typename Model>
void UpdateBlock(const UpdateJob& job, std::size_t begin, std::size_t end, StatusCounts* count) {
  BlockSearch block;
  const int seeds = static_cast<int>(end - begin);
  for (int at = 0; at < seeds; at += kLanes) Prepare<Model>(job, begin + at, end, at, &block);
  const SearchOrder order(block, seeds);
  for (int first = 0; first < order.size(); first += kLanes) {
    if (job.warp) {
      SearchEntries<WarpedSampler>(job, begin, order.At(first), &block);
    } else {
      SearchEntries<AlignedSampler>(job, begin, order.At(first), &block);
    }
  }
  for (int at = 0; at < seeds; at += kLanes) Finish(job, begin + at, end, block, at, count);
}

}  // namespace

void Mark(const MarkJob& job, std::size_t begin, std::size_t end) {
  VisitModel(job.model, [&](auto model) {
    for (std::size_t i = begin; i < end; i += kLanes) MarkLanes<decltype(model)>(job, i, end);
  });
}

UpdateStatistics Update(const UpdateJob& job, std::size_t begin, std::size_t end) {
  StatusCounts count = {};
  VisitModel(job.model, [&](auto model) {
    for (std::size_t i = begin; i < end; i += kBlock) {
      UpdateBlock<decltype(model)>(job, i, std::min(i + kBlock, end), &count);
    }
  });
  UpdateStatistics statistics;
  statistics.matched = count[static_cast<int>(MatchStatus::kMatched)];
  statistics.no_information = count[static_cast<int>(MatchStatus::kNoInformation)];
  statistics.out_of_view = count[static_cast<int>(MatchStatus::kOutOfView)];
  statistics.mismatched = count[static_cast<int>(MatchStatus::kMismatch)];
  return statistics;
}

}  // namespace LIVEMVS_TARGET
}  // namespace livemvs
