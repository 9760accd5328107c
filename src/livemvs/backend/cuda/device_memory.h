#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <string>
#include <utility>

#include "livemvs/backend/backend.h"

namespace livemvs::cuda {

/// @throws DeviceError with what was being done, and CUDA's reason, where it failed.
inline void Check(cudaError_t status, const char* doing) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // it does not stay, for whoever asks next
  throw DeviceError(std::string("GPU: ") + doing + ": " + cudaGetErrorString(status));
}

/// The CUDA stream in which all work of a backend is done, one thing after the other.
class Stream {
 public:
  Stream() { Check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "open a stream"); }
  ~Stream() { cudaStreamDestroy(stream_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  cudaStream_t get() const { return stream_; }

  /// Waits until all that was begun is done.
  void Wait(const char* doing) const { Check(cudaStreamSynchronize(stream_), doing); }

 private:
  cudaStream_t stream_ = nullptr;
};

/// Memory that belongs to whoever holds it.
template <typename T, typename Memory>
class Array {
 public:
  Array() = default;
  explicit Array(std::size_t size) { Reserve(size); }
  ~Array() { Memory::Free(data_); }
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  Array(Array&& other) noexcept { swap(other); }
  Array& operator=(Array&& other) noexcept {
    swap(other);
    return *this;
  }

  void swap(Array& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
  }

  T* get() const { return data_; }
  std::size_t size() const { return size_; }

  /// Makes room for `size` entries, half as many again if it must grow; they are lost then.
  /// Nothing that was begun may still use them.
  void Reserve(std::size_t size) {
    if (size <= size_) return;
    const std::size_t grown = size_ == 0 ? size : size + size / 2;
    Memory::Free(std::exchange(data_, nullptr));
    size_ = 0;
    data_ = static_cast<T*>(Memory::Allocate(grown * sizeof(T)));
    size_ = grown;
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

struct DeviceMemory {
  static void* Allocate(std::size_t bytes) {
    void* data = nullptr;
    const cudaError_t status = cudaMalloc(&data, bytes);
    if (status == cudaErrorMemoryAllocation) {
      std::size_t free = 0, total = 0;
      cudaGetLastError();  // it does not stay
      cudaMemGetInfo(&free, &total);
      throw DeviceError("GPU: " + std::to_string(bytes >> 20) + " MiB more do not fit into its " +
                        std::to_string(total >> 20) + " MiB of memory, of which " +
                        std::to_string(free >> 20) + " MiB are free; keep fewer seeds (--seeds)");
    }
    Check(status, "allocate memory");
    return data;
  }
  static void Free(void* data) { cudaFree(data); }
};

/// Memory of the host that the device reads and writes by itself.
struct PinnedMemory {
  static void* Allocate(std::size_t bytes) {
    void* data = nullptr;
    Check(cudaMallocHost(&data, bytes), "allocate pinned memory");
    return data;
  }
  static void Free(void* data) { cudaFreeHost(data); }
};

template <typename T>
using DeviceArray = Array<T, DeviceMemory>;
template <typename T>
using PinnedArray = Array<T, PinnedMemory>;

/// Begins to copy `count` entries, in either direction; pinned memory alone does not block.
template <typename T>
void Copy(const T* from, T* to, std::size_t count, const Stream& stream) {
  Check(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyDefault, stream.get()),
        "copy memory");
}

/// Makes room for `size` entries, half as many again if the array must grow, and keeps the first
/// `used` of them.
template <typename T>
void Grow(std::size_t size, std::size_t used, const Stream& stream, DeviceArray<T>* array) {
  if (size <= array->size()) return;
  DeviceArray<T> larger(size + size / 2);
  if (used > 0) Copy(array->get(), larger.get(), used, stream);
  stream.Wait("grow memory");
  array->swap(larger);
}

/// An array with a copy in pinned memory, through which it is filled.
template <typename T>
class Table {
 public:
  /// Room for `size` entries, to be written by the host. Nothing may still use those before.
  T* Fill(std::size_t size) {
    host_.Reserve(size);
    device_.Reserve(host_.size());
    return host_.get();
  }

  /// Begins to copy the first `size` entries to the device.
  const T* Upload(std::size_t size, const Stream& stream) {
    Copy(host_.get(), device_.get(), size, stream);
    return device_.get();
  }

  T* device() const { return device_.get(); }
  /// What was filled in.
  const T* host() const { return host_.get(); }

 private:
  PinnedArray<T> host_;
  DeviceArray<T> device_;
};

}  // namespace livemvs::cuda
