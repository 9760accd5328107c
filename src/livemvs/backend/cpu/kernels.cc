// Compiled once per instruction set, with LIVEMVS_TARGET naming it. All that is not a template of
// core's lives in the namespace of that set, so that the linker cannot mix the copies.

#include "livemvs/backend/cpu/kernels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "livemvs/core/texture.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace livemvs {
namespace LIVEMVS_TARGET {
namespace {

// Each needs those before it.
#include "livemvs/backend/cpu/lanes.inc"

#include "livemvs/backend/cpu/words.inc"

#include "livemvs/backend/cpu/matcher.inc"

#include "livemvs/backend/cpu/block.inc"

#include "livemvs/backend/cpu/prepare.inc"

#include "livemvs/backend/cpu/finish.inc"

/// Searches for the patches of some entries of a block, whose first seed is `begin`.
template <typename Sampler>
void SearchEntries(const UpdateJob& job, std::size_t begin, const Int& entry, BlockSearch* block) {
  const RelativeView<float>& view = job.group->view;
  const Lanes scale = Gather(block->scale, entry);
  const SearchBatch batch = {Gather(block->x, entry),
                             Gather(block->y, entry),
                             Gather(block->dx, entry),
                             Gather(block->dy, entry),
                             Gather(block->first, entry),
                             Gather(block->last, entry),
                             scale * view.roll_cos,
                             scale * view.roll_sin};
  const Template t =
      MakeTemplate(LoadPatches(job.seeds.patch + begin * kPatchPixels, entry * kPatchPixels));
  const LineMatch match = SearchLines<Sampler>(batch, t, job.image);
  for (int l = 0; l < kLanes; ++l) {
    block->score[entry[l]] = match.score.v[l];
    block->runner_up[entry[l]] = match.runner_up.v[l];
    block->offset[entry[l]] = match.offset.v[l];
  }
}

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

/// Marks the pixels that the seeds from `begin` on, as many as there are lanes, project to.
template <typename Model>
void MarkLanes(const MarkJob& job, std::size_t begin, std::size_t end) {
  const SeedLanes s(job.seeds, begin, end);
  const RelativeView<float>& view = job.group->view;
  const auto p =
      ProjectSeed<Model>(view, job.coordinate, s.interval, s.bearing_x, s.bearing_y, s.q.mu);
  const Mask inside = s.alive & p.visible & (p.x >= 0.0F) & (p.y >= 0.0F) &
                      (p.x <= view.width - 1) & (p.y <= view.height - 1);
  const Int stride = BroadcastInt(static_cast<std::int32_t>(job.stride));
  const auto rounded = [&](const Lanes& v) { return ToInt(Select(inside, v + 0.5F, 0)); };
  const Int offset = Select(inside, rounded(p.y) * stride + rounded(p.x), BroadcastInt(-1));
  for (int l = 0; l < kLanes; ++l) {
    if (offset[l] < 0) continue;
    std::atomic_ref<std::uint8_t>(job.marks[offset[l]]).store(1, std::memory_order_relaxed);
  }
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
