#pragma once

#include <cstddef>

#include "livemvs/backend/backend.h"

namespace livemvs {

/// The current picture at one level of its pyramid, as the samplers take it.
struct CurrentImage {
  ImageView<std::uint8_t> grey;
  ImageView<std::uint16_t> pairs;  ///< RowPairs of it; needed where sampling grids are warped.
};

/// Pictures wider or higher than this are not sampled on warped grids, whose places are fixed-point
/// numbers [px].
inline constexpr int kMostPixelsWarped = 32'000;

/// What the update of a run of seeds needs beside the seeds.
struct UpdateJob {
  const Options* options;
  const OutlierRule* is_outlier;
  SeedColumns seeds;
  const SeedGroup* group;
  CameraModel model;
  CurrentImage image;
  bool warp;  ///< Turn and scale the sampling grid with the relative pose.
};

/// Step 2 of Algorithm 1 for the seeds [begin, end) of one group.
using UpdateKernel = UpdateStatistics (*)(const UpdateJob& job, std::size_t begin, std::size_t end);

/// The kernel, compiled for several instruction sets.
struct NamedKernel {
  const char* name;
  UpdateKernel update;
};

/// The kernels that this processor can run, the fastest first. Never empty.
std::vector<NamedKernel> UsableKernels();

}  // namespace livemvs
