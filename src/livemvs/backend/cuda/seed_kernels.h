#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <type_traits>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cuda/launch.h"
#include "livemvs/backend/kernel/jobs.h"
#include "livemvs/backend/warp_rule.h"

namespace livemvs::cuda {

/// Threads of a block, each with a seed.
inline constexpr int kSeedsPerBlock = kThreads;

/// Consecutive seeds of one group, for a block of threads.
struct SeedBlock {
  std::uint32_t group;
  std::uint32_t begin, end;
};

/// Whether the sampling grids of a group follow the relative pose; see WarpRule.
enum class Warp : std::uint8_t { kNo, kYes, kAskScale };

/// Number of seeds by MatchStatus.
using StatusTotals = unsigned long long[4];

/// What the kernels work on; pointers are the device's.
struct KernelArguments {
  const Options* options;
  const OutlierRule* is_outlier;
  SeedColumns seeds;
  const SeedGroup* groups;
  const SeedBlock* blocks;
  unsigned block_count;
};

struct UpdateArguments {
  KernelArguments common;
  const CurrentImage* levels;  ///< Of the current frame's pyramid.
  const Warp* warp;            ///< For each group; none is kAskScale.
  StatusTotals* totals;        ///< Are added to.
};

static_assert(std::is_trivially_copyable_v<Options> && std::is_trivially_copyable_v<OutlierRule> &&
              std::is_trivially_copyable_v<SeedGroup> && std::is_trivially_copyable_v<WarpRule>);

// Each begins its work in the stream.

/// Answers what is kAskScale, for groups [0, group_count).
void LaunchChooseWarp(const WarpRule& rule,
                      const SeedColumns& seeds,
                      const SeedGroup* groups,
                      unsigned group_count,
                      Warp* warp,
                      cudaStream_t stream);

/// Writes each pixel beside the one below it; see RowPairs.
void LaunchBuildPairs(const ImageView<std::uint8_t>& grey,
                      std::uint16_t* pairs,
                      cudaStream_t stream);

/// Step 2 of Algorithm 1.
void LaunchUpdate(const UpdateArguments& arguments, CameraModel model, cudaStream_t stream);

/// Marks where living seeds are; `marks` has a picture per level.
void LaunchMark(const KernelArguments& arguments,
                DepthCoordinate coordinate,
                const MarkImage* marks,
                CameraModel model,
                cudaStream_t stream);

}  // namespace livemvs::cuda
