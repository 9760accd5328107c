#include "livemvs/backend/cuda/seed_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>

#include "livemvs/core/texture.h"

namespace livemvs::cuda {
namespace {

// Each needs those before it.
#include "livemvs/backend/kernel/single_lane.inc"

#include "livemvs/backend/kernel/matcher.inc"

#include "livemvs/backend/kernel/block.inc"

#include "livemvs/backend/kernel/prepare.inc"

#include "livemvs/backend/kernel/search.inc"

#include "livemvs/backend/kernel/finish.inc"

#include "livemvs/backend/kernel/mark.inc"

static_assert(kLanes == 1 && kBlock == kSeedsPerBlock);

/// The entries of a block that have something to search for, those with the shortest ranges first,
/// so that the threads of a warp search for about as long.
struct SearchOrder {
  int start[BlockSearch::kIdle + 1];  // of the stretch of entries with each length
  std::uint16_t entry[kBlock];
};

/// Sorts the first `seeds` entries, and returns how many there are to search. Called by all threads
/// of the block, each of which has written its entry.
__device__ int Sort(const BlockSearch& block, int seeds, SearchOrder* order) {
  constexpr int kLengths = BlockSearch::kIdle + 1, kWarp = 32;
  static_assert(kLengths == 2 * kWarp);
  const int t = static_cast<int>(threadIdx.x);
  if (t < kLengths) order->start[t] = 0;
  __syncthreads();
  const int length = t < seeds ? block.length[t] : 0;
  if (t < seeds) atomicAdd(&order->start[length], 1);
  __syncthreads();
  if (t < kWarp) {
    const int even = order->start[2 * t], odd = order->start[2 * t + 1];
    int sum = even + odd;  // of the lengths up to the thread's two
    for (int step = 1; step < kWarp; step *= 2) {
      const int before = __shfl_up_sync(~0U, sum, step);
      if (t >= step) sum += before;
    }
    order->start[2 * t] = sum - odd - even;
    order->start[2 * t + 1] = sum - odd;
  }
  __syncthreads();
  const int searched = order->start[BlockSearch::kIdle];
  __syncthreads();
  if (t < seeds) order->entry[atomicAdd(&order->start[length], 1)] = static_cast<std::uint16_t>(t);
  __syncthreads();
  return searched;
}

template <typename Model>
__global__ void __launch_bounds__(kSeedsPerBlock)
    UpdateSeeds(UpdateArguments a, CameraModel model) {
  __shared__ BlockSearch block;
  __shared__ SearchOrder order;
  const SeedBlock range = a.common.blocks[blockIdx.x];
  const SeedGroup* group = a.common.groups + range.group;
  const UpdateJob job = {a.common.options,
                         a.common.is_outlier,
                         a.common.seeds,
                         group,
                         model,
                         a.levels[group->level],
                         a.warp[range.group] == Warp::kYes};
  const int t = static_cast<int>(threadIdx.x), seeds = static_cast<int>(range.end - range.begin);
  if (t < seeds) Prepare<Model>(job, range.begin + t, range.end, t, &block);
  const int searched = Sort(block, seeds, &order);
  if (t < searched) {
    if (job.warp) {
      SearchEntries<WarpedSampler>(job, range.begin, order.entry[t], &block);
    } else {
      SearchEntries<AlignedSampler>(job, range.begin, order.entry[t], &block);
    }
  }
  __syncthreads();
  StatusCounts count = {};
  if (t < seeds) Finish(job, range.begin + t, range.end, block, t, &count);
  for (int v = 0; v < 4; ++v) {
    const int sum = __syncthreads_count(count[v] != 0);
    if (t == 0 && sum > 0) atomicAdd(&(*a.totals)[v], static_cast<unsigned long long>(sum));
  }
}

template <typename Model>
__global__ void MarkSeeds(KernelArguments a,
                          DepthCoordinate coordinate,
                          const MarkImage* marks,
                          CameraModel model) {
  const SeedBlock range = a.blocks[blockIdx.x];
  const SeedGroup* group = a.groups + range.group;
  const MarkJob job = {coordinate, a.seeds, group, model, marks[group->level]};
  const std::uint32_t i = range.begin + threadIdx.x;
  if (i < range.end) MarkLanes<Model>(job, i, range.end);
}

/// The first living seed of [begin, end), for all threads of the block; `end` if there is none.
__device__ std::uint32_t FirstAlive(const Fate* fate,
                                    std::uint32_t begin,
                                    std::uint32_t end,
                                    std::uint32_t* shared) {
  if (threadIdx.x == 0) *shared = end;
  __syncthreads();
  for (std::uint32_t at = begin; at < end; at += kSeedsPerBlock) {
    const std::uint32_t i = at + threadIdx.x;
    const bool alive = i < end && fate[i] == Fate::kAlive;
    if (alive) atomicMin(shared, i);
    if (__syncthreads_or(alive)) break;
  }
  const std::uint32_t first = *shared;
  __syncthreads();
  return first;
}

__global__ void ChooseWarp(WarpRule rule, SeedColumns seeds, const SeedGroup* groups, Warp* warp) {
  __shared__ std::uint32_t shared;
  if (warp[blockIdx.x] != Warp::kAskScale) return;
  const SeedGroup& group = groups[blockIdx.x];
  const auto begin = static_cast<std::uint32_t>(group.begin);
  const auto end = static_cast<std::uint32_t>(group.end);
  const std::uint32_t middle = (begin + end) / 2;
  std::uint32_t living = FirstAlive(seeds.fate, middle, end, &shared);
  bool found = living != end;
  if (!found) {
    living = FirstAlive(seeds.fate, begin, middle, &shared);
    found = living != middle;
  }
  __syncthreads();  // all have read the question
  if (threadIdx.x > 0) return;
  const bool scaled = found && rule.Scaled(group.view, seeds, living);
  warp[blockIdx.x] = scaled ? Warp::kYes : Warp::kNo;
}

__global__ void BuildPairs(ImageView<std::uint8_t> grey, std::uint16_t* pairs) {
  const int x = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  const int y = static_cast<int>(blockIdx.y);
  if (x >= grey.stride) return;  // what is read beyond a row is written, too
  const int below = y + 1 < grey.height ? y + 1 : y;
  const std::uint8_t* upper = grey.data + y * grey.stride;
  const std::uint8_t* lower = grey.data + below * grey.stride;
  pairs[y * grey.stride + x] = static_cast<std::uint16_t>((upper[x] | lower[x] << 8) ^ 0x8080);
}

}  // namespace

void LaunchChooseWarp(const WarpRule& rule,
                      const SeedColumns& seeds,
                      const SeedGroup* groups,
                      unsigned group_count,
                      Warp* warp,
                      cudaStream_t stream) {
  Launch("choose sampling grids", ChooseWarp, dim3(group_count), stream, rule, seeds, groups, warp);
}

void LaunchBuildPairs(const ImageView<std::uint8_t>& grey,
                      std::uint16_t* pairs,
                      cudaStream_t stream) {
  const dim3 across = BlocksFor(static_cast<std::size_t>(grey.stride));
  const dim3 blocks(across.x, static_cast<unsigned>(grey.height));
  Launch("pair rows of pixels", BuildPairs, blocks, stream, grey, pairs);
}

void LaunchUpdate(const UpdateArguments& arguments, CameraModel model, cudaStream_t stream) {
  const dim3 blocks(arguments.common.block_count);
  VisitModel(model, [&](auto m) {
    Launch("update seeds", UpdateSeeds<decltype(m)>, blocks, stream, arguments, model);
  });
}

void LaunchMark(const KernelArguments& arguments,
                DepthCoordinate coordinate,
                const MarkImage* marks,
                CameraModel model,
                cudaStream_t stream) {
  const dim3 blocks(arguments.block_count);
  VisitModel(model, [&](auto m) {
    Launch(
        "mark seeds", MarkSeeds<decltype(m)>, blocks, stream, arguments, coordinate, marks, model);
  });
}

}  // namespace livemvs::cuda
