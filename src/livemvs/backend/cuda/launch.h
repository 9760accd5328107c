#pragma once

#include <cuda_runtime.h>

#include <cstddef>

namespace livemvs::cuda {

// Kernels with a thread for each thing.

inline constexpr int kThreads = 256;

inline unsigned BlocksFor(std::size_t threads) {
  return static_cast<unsigned>((threads + kThreads - 1) / kThreads);
}

__device__ inline std::size_t ThreadNumber() {
  return std::size_t{blockIdx.x} * kThreads + threadIdx.x;
}

}  // namespace livemvs::cuda
