#pragma once

// What the CUDA backend uses of CUDA, on the CPU: its sources, compiled as C++ with this folder
// before CUDA's in the path, run as they are. It is for finding faults without a device, not fast:
//
// - Work in a stream is not begun before something waits for it, as late as a device may do it.
// - The threads of a block are fibres, which stop where they wait for each other. Blocks and
//   threads run in an order that changes from launch to launch.
// - Memory of the device is filled with rubbish when allocated. The address sanitizer sees where
//   kernels, and copies, leave what was allocated.
//
// It does not see host code that reads the device's memory, kernels that read the host's stack, and
// shared memory that is read before it is written: that begins as the block before left it.
//
// There is a device only where kEmulatedGpuVariable is set.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <tuple>
#include <type_traits>

#define __global__
#define __device__
#define __host__
#define __shared__ static
#define __launch_bounds__(threads)

/// An environment variable with the memory of the emulated device [MiB].
inline constexpr const char* kEmulatedGpuVariable = "LIVEMVS_EMULATED_GPU";

struct dim3 {
  unsigned x = 1, y = 1, z = 1;
  dim3() = default;
  explicit dim3(unsigned across, unsigned down = 1) : x(across), y(down) {}
};

enum cudaError_t {
  cudaSuccess = 0,
  cudaErrorInvalidValue = 1,
  cudaErrorMemoryAllocation = 2,
  cudaErrorInvalidConfiguration = 9,
  cudaErrorNoDevice = 100,
  cudaErrorLaunchFailure = 719,
};

struct cudaDeviceProp {
  char name[256];
  int major, minor;
  std::size_t totalGlobalMem;
};

enum cudaMemcpyKind { cudaMemcpyDefault = 4 };
inline constexpr unsigned cudaStreamNonBlocking = 1;

struct CUstream_st;
using cudaStream_t = CUstream_st*;

struct cudaLaunchConfig_t {
  dim3 gridDim, blockDim;
  std::size_t dynamicSmemBytes = 0;
  cudaStream_t stream = nullptr;
};

const char* cudaGetErrorString(cudaError_t status);
cudaError_t cudaGetLastError();
cudaError_t cudaGetDeviceCount(int* count);
cudaError_t cudaDriverGetVersion(int* version);
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int device);
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total);
cudaError_t cudaMalloc(void** data, std::size_t bytes);
cudaError_t cudaFree(void* data);
cudaError_t cudaMallocHost(void** data, std::size_t bytes);
cudaError_t cudaFreeHost(void* data);
cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned flags);
cudaError_t cudaStreamDestroy(cudaStream_t stream);
cudaError_t cudaStreamSynchronize(cudaStream_t stream);
cudaError_t cudaMemcpyAsync(
    void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, cudaStream_t stream);
cudaError_t cudaMemsetAsync(void* data, int value, std::size_t bytes, cudaStream_t stream);

namespace emulated_cuda {

/// Where the running thread is.
struct Place {
  dim3 thread, block, block_size;
};
extern Place place;

/// Has the stream do `work`, later.
cudaError_t Enqueue(cudaStream_t stream, std::function<void()> work);
/// Has the stream run `thread` once for each thread of the blocks, later.
cudaError_t EnqueueKernel(const cudaLaunchConfig_t& config, std::function<void()> thread);

/// Waits for the block's threads; returns in how many `condition` holds.
int WaitForBlock(bool condition);
/// Waits for the warp's threads with bits in `mask`; returns what the one `delta` lanes below has.
std::uint64_t ShuffleUp(std::uint32_t mask, std::uint64_t value, unsigned delta);

/// Whether work is done when it is begun, as early as a device may do it; otherwise when it is
/// waited for.
void WorkAtOnce(bool at_once);
/// From now on the device is lost after `operations` more: copies, kernels, selections; -1: never.
void LoseDeviceAfter(int operations);
/// Operations so far.
int Operations();

}  // namespace emulated_cuda

inline const dim3& threadIdx = emulated_cuda::place.thread;
inline const dim3& blockIdx = emulated_cuda::place.block;
inline const dim3& blockDim = emulated_cuda::place.block_size;

template <typename... Parameters, typename... Arguments>
cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* config,
                               void (*kernel)(Parameters...),
                               Arguments&&... arguments) {
  static_assert((std::is_trivially_copyable_v<Parameters> && ...), "copied to the device");
  const std::tuple<Parameters...> copied(arguments...);
  return emulated_cuda::EnqueueKernel(*config, [=] { std::apply(kernel, copied); });
}

inline void __syncthreads() { emulated_cuda::WaitForBlock(false); }
inline int __syncthreads_count(int condition) {
  return emulated_cuda::WaitForBlock(condition != 0);
}
inline int __syncthreads_or(int condition) { return __syncthreads_count(condition) > 0 ? 1 : 0; }
inline int __shfl_up_sync(std::uint32_t mask, int value, unsigned delta) {
  return static_cast<int>(emulated_cuda::ShuffleUp(mask, static_cast<std::uint32_t>(value), delta));
}

// Threads take turns: nothing comes between.
template <typename T>
T atomicAdd(T* sum, T value) {
  const T before = *sum;
  *sum = before + value;
  return before;
}
template <typename T>
T atomicMin(T* least, T value) {
  const T before = *least;
  if (value < before) *least = value;
  return before;
}

/// The word that begins `shift` bits above the lowest of two, modulo 32.
inline std::uint32_t __funnelshift_r(std::uint32_t low, std::uint32_t high, std::uint32_t shift) {
  return static_cast<std::uint32_t>(((std::uint64_t{high} << 32) | low) >> (shift & 31));
}
