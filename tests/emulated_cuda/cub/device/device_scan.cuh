#pragma once

#include <cuda_runtime.h>

#include <cstddef>

#include "cub/device/emulated_algorithm.h"

namespace cub {

struct DeviceScan {
  template <typename In, typename Out>
  static cudaError_t ExclusiveSum(
      void* scratch, std::size_t& bytes, In in, Out* out, int n, cudaStream_t stream) {
    return EnqueueAlgorithm(scratch, bytes, n, stream, [=] {
      Out sum = 0;
      for (int i = 0; i < n; ++i) {
        const Out value = in[i];  // before: `out` may be where it is read
        out[i] = sum;
        sum += value;
      }
    });
  }
};

}  // namespace cub
