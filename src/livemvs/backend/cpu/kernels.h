#pragma once

#include <cstddef>

#include "livemvs/backend/backend.h"

namespace livemvs {

/// What the update of a run of seeds needs beside the seeds.
struct UpdateJob {
  const Options* options;
  const OutlierRule* is_outlier;
  SeedColumns seeds;
  const SeedGroup* group;
  CameraModel model;
  ImageView<std::uint8_t> image;
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
