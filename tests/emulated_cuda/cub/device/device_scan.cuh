#pragma once

#include <cuda_runtime.h>

#include <cstddef>

namespace cub {

struct DeviceScan {
  /// Tells the bytes of scratch memory that it needs where there is none.
  template <typename In, typename Out>
  static cudaError_t ExclusiveSum(
      void* scratch, std::size_t& bytes, In in, Out* out, int n, cudaStream_t stream) {
    const std::size_t needed = 1 + static_cast<std::size_t>(n) / 256;
    if (scratch == nullptr) {
      bytes = needed;
      return cudaSuccess;
    }
    if (bytes < needed) return cudaErrorInvalidValue;
    return emulated_cuda::Enqueue(stream, [=] {
      std::memset(scratch, 0xA5, needed);
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
