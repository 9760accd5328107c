#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

namespace cub {

// Each tells the bytes of scratch memory that it needs where there is none.
struct DeviceSelect {
  template <typename In, typename Out, typename Count, typename Predicate>
  static cudaError_t If(void* scratch,
                        std::size_t& bytes,
                        In in,
                        Out* out,
                        Count* count,
                        int n,
                        Predicate predicate,
                        cudaStream_t stream) {
    const std::size_t needed = 1 + static_cast<std::size_t>(n) / 256;
    if (scratch == nullptr) {
      bytes = needed;
      return cudaSuccess;
    }
    if (bytes < needed) return cudaErrorInvalidValue;
    return emulated_cuda::Enqueue(stream, [=] {
      std::memset(scratch, 0xA5, needed);
      Count selected = 0;
      for (int i = 0; i < n; ++i) {
        const auto value = in[i];
        if (predicate(value)) out[selected++] = value;
      }
      *count = selected;
    });
  }

  template <typename In, typename Flag, typename Out, typename Count>
  static cudaError_t Flagged(void* scratch,
                             std::size_t& bytes,
                             const In* in,
                             const Flag* flags,
                             Out* out,
                             Count* count,
                             int n,
                             cudaStream_t stream) {
    const std::size_t needed = 1 + static_cast<std::size_t>(n) / 256;
    if (scratch == nullptr) {
      bytes = needed;
      return cudaSuccess;
    }
    if (bytes < needed) return cudaErrorInvalidValue;
    return emulated_cuda::Enqueue(stream, [=] {
      std::memset(scratch, 0xA5, needed);
      Count selected = 0;
      for (int i = 0; i < n; ++i) {
        if (flags[i]) out[selected++] = in[i];
      }
      *count = selected;
    });
  }
};

}  // namespace cub
