#include <cuda_runtime.h>
#include <sys/mman.h>
#include <ucontext.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
#define EMULATED_CUDA_FIBRES_ARE_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define EMULATED_CUDA_FIBRES_ARE_SANITIZED
#endif
#endif
#if defined(EMULATED_CUDA_FIBRES_ARE_SANITIZED)
#include <sanitizer/common_interface_defs.h>
#endif

struct CUstream_st {
  std::deque<std::function<void()>> work;
};

namespace emulated_cuda {

Place place;

namespace {

constexpr unsigned kWarp = 32;
constexpr std::size_t kStackBytes = std::size_t{256} << 10;

// A kernel that no device would run to its end.
class LaunchFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What a thread that has stopped waits for.
enum class Waits { kNot, kForBlock, kForWarp };

// A thread of a block, on a stack of its own.
struct Fibre {
  ucontext_t context;
  void* stack = nullptr;
  void* fake_stack = nullptr;  // of the address sanitizer
  bool done = true;
  Waits waits = Waits::kNot;
  std::uint64_t given = 0;   // to those that it waits for
  std::uint64_t result = 0;  // of the wait
  std::uint32_t mask = 0;    // of the warp
  unsigned delta = 0;
};

// Runs the threads of one block after the other.
class Multiprocessor {
 public:
  void Run(const std::function<void()>& thread, dim3 block, unsigned threads, bool backwards) {
    thread_ = &thread;
    place.block = block;
    place.block_size = dim3(threads);
    while (fibres_.size() < threads) Add();
    for (unsigned t = 0; t < threads; ++t) {
      fibres_[t]->done = false;
      fibres_[t]->waits = Waits::kNot;
    }
    for (;;) {
      for (unsigned k = 0; k < threads; ++k) {
        const unsigned t = backwards ? threads - 1 - k : k;
        if (!fibres_[t]->done && fibres_[t]->waits == Waits::kNot) Enter(t);
      }
      if (!Release(threads)) return;
    }
  }

  // Forgets threads that will not go on.
  void Discard() {
    for (const auto& fibre : fibres_) munmap(fibre->stack, kStackBytes);
    fibres_.clear();
  }

  // Called by a thread: stops until it is released, and returns the result.
  std::uint64_t Wait(Waits waits, std::uint64_t given, std::uint32_t mask, unsigned delta) {
    Fibre& fibre = *fibres_[running_];
    fibre.waits = waits;
    fibre.given = given;
    fibre.mask = mask;
    fibre.delta = delta;
    Leave();
    return fibre.result;
  }

 private:
  void Add() {
    auto fibre = std::make_unique<Fibre>();
    fibre->stack =
        mmap(nullptr, kStackBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (fibre->stack == MAP_FAILED) throw std::bad_alloc();
    getcontext(&fibre->context);
    fibre->context.uc_stack.ss_sp = fibre->stack;
    fibre->context.uc_stack.ss_size = kStackBytes;
    fibre->context.uc_link = nullptr;
    makecontext(&fibre->context, &Multiprocessor::Main, 0);
    fibres_.push_back(std::move(fibre));
  }

  static void Main();

  // What a fibre does: one thread after the other.
  [[noreturn]] void RunThreads() {
    for (;;) {
      (*thread_)();
      fibres_[running_]->done = true;
      Leave();
    }
  }

  void Enter(unsigned t) {
    running_ = t;
    place.thread.x = t;
#if defined(EMULATED_CUDA_FIBRES_ARE_SANITIZED)
    __sanitizer_start_switch_fiber(&fake_stack_, fibres_[t]->stack, kStackBytes);
#endif
    swapcontext(&context_, &fibres_[t]->context);
#if defined(EMULATED_CUDA_FIBRES_ARE_SANITIZED)
    __sanitizer_finish_switch_fiber(fake_stack_, nullptr, nullptr);
#endif
  }

  void Leave() {
    Fibre& fibre = *fibres_[running_];
#if defined(EMULATED_CUDA_FIBRES_ARE_SANITIZED)
    __sanitizer_start_switch_fiber(&fibre.fake_stack, stack_, stack_bytes_);
#endif
    swapcontext(&fibre.context, &context_);
    Arrive(&fibre);
  }

  // The first that a fibre does after it was entered.
  void Arrive(Fibre* fibre) {
#if defined(EMULATED_CUDA_FIBRES_ARE_SANITIZED)
    __sanitizer_finish_switch_fiber(fibre->fake_stack, &stack_, &stack_bytes_);
#else
    static_cast<void>(fibre);
#endif
  }

  // Lets go on who has waited for all that it waits for. False: all are done.
  // @throws LaunchFailure where nobody can go on.
  bool Release(unsigned threads) {
    unsigned left = 0, at_block = 0;
    bool released = false;
    for (unsigned t = 0; t < threads; ++t) {
      left += !fibres_[t]->done;
      at_block += !fibres_[t]->done && fibres_[t]->waits == Waits::kForBlock;
    }
    if (left == 0) return false;
    if (at_block == left) {
      std::uint64_t count = 0;
      for (unsigned t = 0; t < threads; ++t) count += !fibres_[t]->done && fibres_[t]->given != 0;
      for (unsigned t = 0; t < threads; ++t) {
        fibres_[t]->result = count;
        fibres_[t]->waits = Waits::kNot;
      }
      return true;
    }
    for (unsigned first = 0; first < threads; first += kWarp)
      released |= ReleaseWarp(first, threads);
    if (released) return true;
    throw LaunchFailure("the threads of a block wait for each other at different places");
  }

  bool ReleaseWarp(unsigned first, unsigned threads) {
    std::uint32_t waiting = 0, mask = 0;
    for (unsigned lane = 0; lane < kWarp && first + lane < threads; ++lane) {
      const Fibre& fibre = *fibres_[first + lane];
      if (fibre.done || fibre.waits != Waits::kForWarp) continue;
      if (waiting != 0 && fibre.mask != mask) return false;
      waiting |= std::uint32_t{1} << lane;
      mask = fibre.mask;
    }
    if (waiting == 0 || waiting != mask) return false;
    std::uint64_t given[kWarp] = {};
    for (unsigned lane = 0; lane < kWarp && first + lane < threads; ++lane) {
      given[lane] = fibres_[first + lane]->given;
    }
    for (unsigned lane = 0; lane < kWarp && first + lane < threads; ++lane) {
      if (((waiting >> lane) & 1) == 0) continue;
      Fibre& fibre = *fibres_[first + lane];
      fibre.result = given[lane >= fibre.delta ? lane - fibre.delta : lane];
      fibre.waits = Waits::kNot;
    }
    return true;
  }

  const std::function<void()>* thread_ = nullptr;
  std::vector<std::unique_ptr<Fibre>> fibres_;  // kept: they are dear to make
  unsigned running_ = 0;
  ucontext_t context_;  // of who runs the block
  void* fake_stack_ = nullptr;
  const void* stack_ = nullptr;
  std::size_t stack_bytes_ = 0;
};

struct Allocation {
  std::size_t bytes;
  bool on_device;
};

// One at a time uses the device.
struct Device {
  std::recursive_mutex mutex;
  std::map<const char*, Allocation> memory;
  std::size_t used = 0;
  std::set<cudaStream_t> streams;
  Multiprocessor multiprocessor;
  cudaError_t last = cudaSuccess;
  bool lost = false;
  int launches = 0;
  bool works_at_once = false;
  int operations = 0;
  int operations_left = -1;
};

Device& TheDevice() {
  static auto* device = new Device;  // never deleted: who frees memory last is not known
  return *device;
}

void Multiprocessor::Main() {
  Multiprocessor& self = TheDevice().multiprocessor;
  self.Arrive(self.fibres_[self.running_].get());
  self.RunThreads();
}

std::size_t MemoryOfTheDevice() {
  const char* mebibytes = std::getenv(kEmulatedGpuVariable);
  return mebibytes == nullptr ? 0 : std::strtoull(mebibytes, nullptr, 10) << 20;
}

cudaError_t Remember(cudaError_t status) {
  if (status != cudaSuccess) TheDevice().last = status;
  return status;
}

// The allocation with [data, data + bytes); null if none has all of it.
const Allocation* AllocationOf(const void* data, std::size_t bytes) {
  auto& memory = TheDevice().memory;
  const auto* at = static_cast<const char*>(data);
  auto next = memory.upper_bound(at);
  if (next == memory.begin()) return nullptr;
  const auto& [begin, allocation] = *--next;
  const auto offset = static_cast<std::size_t>(at - begin);
  if (offset > allocation.bytes || bytes > allocation.bytes - offset) return nullptr;
  return &allocation;
}

// Whether memory begins in an allocation, and leaves it.
bool Overruns(const void* data, std::size_t bytes) {
  return AllocationOf(data, bytes) == nullptr && AllocationOf(data, 1) != nullptr;
}

cudaError_t RunAll(cudaStream_t stream) {
  Device& device = TheDevice();
  while (!stream->work.empty() && !device.lost) {
    const std::function<void()> work = std::move(stream->work.front());
    stream->work.pop_front();
    ++device.operations;
    if (device.operations_left == 0) device.lost = true;
    if (device.operations_left > 0) --device.operations_left;
    if (device.lost) break;
    try {
      work();
    } catch (const LaunchFailure& failure) {
      std::fprintf(stderr, "emulated GPU: %s\n", failure.what());
      device.multiprocessor.Discard();
      device.lost = true;
    }
  }
  stream->work.clear();
  return Remember(device.lost ? cudaErrorLaunchFailure : cudaSuccess);
}

cudaError_t Allocate(void** data, std::size_t bytes, bool on_device) {
  Device& device = TheDevice();
  const std::lock_guard lock(device.mutex);
  if (device.lost) return Remember(cudaErrorLaunchFailure);
  *data = nullptr;
  if (bytes == 0) return cudaSuccess;
  if (on_device && bytes > MemoryOfTheDevice() - std::min(MemoryOfTheDevice(), device.used)) {
    return Remember(cudaErrorMemoryAllocation);
  }
  constexpr std::size_t kAlignment = 256;
  if (posix_memalign(data, kAlignment, bytes) != 0) return Remember(cudaErrorMemoryAllocation);
  std::memset(*data, 0xA5, bytes);
  device.memory[static_cast<const char*>(*data)] = {bytes, on_device};
  if (on_device) device.used += bytes;
  return cudaSuccess;
}

cudaError_t Free(void* data, bool on_device) {
  Device& device = TheDevice();
  const std::lock_guard lock(device.mutex);
  if (data == nullptr) return cudaSuccess;
  const auto found = device.memory.find(static_cast<const char*>(data));
  if (found == device.memory.end() || found->second.on_device != on_device) {
    return Remember(cudaErrorInvalidValue);
  }
  for (const cudaStream_t stream : device.streams) RunAll(stream);  // it may be in use
  if (on_device) device.used -= found->second.bytes;
  device.memory.erase(found);
  std::free(data);
  return cudaSuccess;
}

}  // namespace

cudaError_t Enqueue(cudaStream_t stream, std::function<void()> work) {
  Device& device = TheDevice();
  const std::lock_guard lock(device.mutex);
  if (device.lost) return Remember(cudaErrorLaunchFailure);
  stream->work.push_back(std::move(work));
  return device.works_at_once ? RunAll(stream) : cudaSuccess;
}

cudaError_t EnqueueKernel(const cudaLaunchConfig_t& config, std::function<void()> thread) {
  const dim3 blocks = config.gridDim;
  const unsigned threads = config.blockDim.x;
  if (blocks.x == 0 || blocks.y == 0 || blocks.y > 65'535 || threads == 0 || threads > 1024 ||
      threads % kWarp != 0) {
    return Remember(cudaErrorInvalidConfiguration);
  }
  Device& device = TheDevice();
  const std::lock_guard lock(device.mutex);
  const bool backwards = ++device.launches % 2 == 0;
  return Enqueue(config.stream, [=, thread = std::move(thread)] {
    const std::size_t n = std::size_t{blocks.x} * blocks.y;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t b = backwards ? n - 1 - k : k;
      dim3 block;
      block.x = static_cast<unsigned>(b % blocks.x);
      block.y = static_cast<unsigned>(b / blocks.x);
      TheDevice().multiprocessor.Run(thread, block, threads, (b % 2 == 1) != backwards);
    }
  });
}

int WaitForBlock(bool condition) {
  return static_cast<int>(
      TheDevice().multiprocessor.Wait(Waits::kForBlock, condition ? 1 : 0, 0, 0));
}

std::uint64_t ShuffleUp(std::uint32_t mask, std::uint64_t value, unsigned delta) {
  return TheDevice().multiprocessor.Wait(Waits::kForWarp, value, mask, delta);
}

void WorkAtOnce(bool at_once) { TheDevice().works_at_once = at_once; }

void LoseDeviceAfter(int operations) {
  TheDevice().operations_left = operations;
  TheDevice().lost = false;
}

int Operations() { return TheDevice().operations; }

}  // namespace emulated_cuda

using namespace emulated_cuda;

const char* cudaGetErrorString(cudaError_t status) {
  switch (status) {
    case cudaSuccess:
      return "no error";
    case cudaErrorInvalidValue:
      return "invalid argument";
    case cudaErrorMemoryAllocation:
      return "out of memory";
    case cudaErrorInvalidConfiguration:
      return "invalid configuration argument";
    case cudaErrorNoDevice:
      return "no CUDA-capable device is detected";
    case cudaErrorLaunchFailure:
      return "unspecified launch failure";
  }
  return "unrecognized error code";
}

cudaError_t cudaGetLastError() { return std::exchange(TheDevice().last, cudaSuccess); }

cudaError_t cudaGetDeviceCount(int* count) {
  *count = MemoryOfTheDevice() > 0 ? 1 : 0;
  return *count > 0 ? cudaSuccess : Remember(cudaErrorNoDevice);
}

cudaError_t cudaDriverGetVersion(int* version) {
  *version = MemoryOfTheDevice() > 0 ? 13'000 : 0;
  return cudaSuccess;
}

cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int device) {
  if (device != 0 || MemoryOfTheDevice() == 0) return Remember(cudaErrorInvalidValue);
  *properties = {"emulated on the CPU", 9, 0, MemoryOfTheDevice()};
  return cudaSuccess;
}

cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  *total = MemoryOfTheDevice();
  *free = *total - std::min(*total, TheDevice().used);
  return cudaSuccess;
}

cudaError_t cudaMalloc(void** data, std::size_t bytes) { return Allocate(data, bytes, true); }
cudaError_t cudaFree(void* data) { return Free(data, true); }
cudaError_t cudaMallocHost(void** data, std::size_t bytes) { return Allocate(data, bytes, false); }
cudaError_t cudaFreeHost(void* data) { return Free(data, false); }

cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned flags) {
  if (flags != cudaStreamNonBlocking) return Remember(cudaErrorInvalidValue);
  Device& device = TheDevice();
  const std::lock_guard lock(device.mutex);
  if (device.lost) return Remember(cudaErrorLaunchFailure);
  *stream = *device.streams.insert(new CUstream_st).first;
  return cudaSuccess;
}

cudaError_t cudaStreamDestroy(cudaStream_t stream) {
  Device& device = TheDevice();
  const std::lock_guard lock(device.mutex);
  const cudaError_t status = RunAll(stream);
  device.streams.erase(stream);
  delete stream;
  return status;
}

cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
  const std::lock_guard lock(TheDevice().mutex);
  return RunAll(stream);
}

cudaError_t cudaMemcpyAsync(
    void* to, const void* from, std::size_t bytes, cudaMemcpyKind, cudaStream_t stream) {
  const std::lock_guard lock(TheDevice().mutex);
  if (bytes == 0) return cudaSuccess;
  if (Overruns(to, bytes) || Overruns(from, bytes)) return Remember(cudaErrorInvalidValue);
  if (AllocationOf(from, bytes) == nullptr) {  // what may be paged out is copied at once
    const auto* begin = static_cast<const char*>(from);
    return Enqueue(stream, [to, copy = std::vector<char>(begin, begin + bytes)] {
      std::copy(copy.begin(), copy.end(), static_cast<char*>(to));
    });
  }
  const cudaError_t status = Enqueue(stream, [=] { std::memcpy(to, from, bytes); });
  if (status != cudaSuccess || AllocationOf(to, bytes) != nullptr) return status;
  return RunAll(stream);  // nor is it written later
}

cudaError_t cudaMemsetAsync(void* data, int value, std::size_t bytes, cudaStream_t stream) {
  const std::lock_guard lock(TheDevice().mutex);
  if (AllocationOf(data, bytes) == nullptr) return Remember(cudaErrorInvalidValue);
  return Enqueue(stream, [=] { std::memset(data, value, bytes); });
}
