#pragma once

#include <cstddef>
#include <cstdint>

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

/// What marking the places of a run of seeds needs.
struct MarkJob {
  DepthCoordinate coordinate;
  SeedColumns seeds;
  const SeedGroup* group;
  CameraModel model;
  std::uint8_t* marks;  ///< Of the size of the group's level of the pyramid.
  std::ptrdiff_t stride;
};

/// Sets the pixels to 1 that seeds [begin, end) of one group project to. Several threads may write
/// to the same picture.
using MarkKernel = void (*)(const MarkJob& job, std::size_t begin, std::size_t end);

/// The kernels, compiled for several instruction sets.
struct NamedKernel {
  const char* name;
  UpdateKernel update;
  MarkKernel mark;
};

/// The kernels that this processor can run, the fastest first. Never empty.
std::vector<NamedKernel> UsableKernels();

}  // namespace livemvs
