#pragma once

#include <cstddef>
#include <vector>

#include "livemvs/backend/kernel/jobs.h"

namespace livemvs {

/// Step 2 of Algorithm 1 for the seeds [begin, end) of one group.
using UpdateKernel = UpdateStatistics (*)(const UpdateJob& job, std::size_t begin, std::size_t end);

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
