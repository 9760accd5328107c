#pragma once

#include <cuda_runtime.h>

#include <cstddef>

#include "cub/device/emulated_algorithm.h"

namespace cub {

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
    return EnqueueAlgorithm(scratch, bytes, n, stream, [=] {
      Keep(in, out, count, n, [&](int i) { return predicate(in[i]); });
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
    return EnqueueAlgorithm(scratch, bytes, n, stream, [=] {
      Keep(in, out, count, n, [&](int i) { return flags[i]; });
    });
  }

 private:
  template <typename In, typename Out, typename Count, typename IsKept>
  static void Keep(In in, Out* out, Count* count, int n, const IsKept& is_kept) {
    Count kept = 0;
    for (int i = 0; i < n; ++i) {
      if (is_kept(i)) out[kept++] = in[i];
    }
    *count = kept;
  }
};

}  // namespace cub
