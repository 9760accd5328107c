#pragma once

#include <cuda_runtime.h>

#include <cstddef>

namespace cub {

/// Has the stream do `work` on n things, as CUB's algorithms do: without scratch memory this tells
/// the bytes that are needed; with it, what it holds is lost.
template <typename Work>
cudaError_t EnqueueAlgorithm(
    void* scratch, std::size_t& bytes, int n, cudaStream_t stream, const Work& work) {
  const std::size_t needed = 1 + static_cast<std::size_t>(n) / 256;
  if (scratch == nullptr) {
    bytes = needed;
    return cudaSuccess;
  }
  if (bytes < needed) return cudaErrorInvalidValue;
  return emulated_cuda::Enqueue(stream, [=] {
    std::memset(scratch, 0xA5, needed);
    work();
  });
}

}  // namespace cub
