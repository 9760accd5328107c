#pragma once

#include <cuda_runtime.h>

#include <cstddef>

#include "livemvs/backend/cuda/device_memory.h"

namespace livemvs::cuda {

/// Threads of a block.
inline constexpr int kThreads = 256;

/// Blocks that have a thread for each of `things`.
inline dim3 BlocksFor(std::size_t things) {
  return dim3(static_cast<unsigned>((things + kThreads - 1) / kThreads));
}

/// The thing of this thread.
__device__ inline std::size_t ThreadNumber() {
  return std::size_t{blockIdx.x} * kThreads + threadIdx.x;
}

/// Begins a kernel in the stream; there must be a block.
/// @param doing  What it does, for the error.
template <typename... Parameters, typename... Arguments>
void Launch(const char* doing,
            void (*kernel)(Parameters...),
            dim3 blocks,
            cudaStream_t stream,
            const Arguments&... arguments) {
  cudaLaunchConfig_t config = {};
  config.gridDim = blocks;
  config.blockDim = dim3(kThreads);
  config.stream = stream;
  Check(cudaLaunchKernelEx(&config, kernel, arguments...), doing);
}

}  // namespace livemvs::cuda
