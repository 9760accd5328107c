#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "livemvs/backend/backend.h"

namespace livemvs {

/// A GPU that CUDA knows.
struct CudaDevice {
  std::string name;
  int major, minor;     ///< Compute capability.
  std::size_t memory;   ///< [bytes]
  std::string trouble;  ///< Why it cannot be used; empty: it can.
};

/// What GPUs there are.
struct CudaDevices {
  std::vector<CudaDevice> devices;
  std::string trouble;  ///< Why there are none; empty where there are some.
};

CudaDevices FindCudaDevices();

/// The CUDA backend, on the first device. Options are copied; the device's memory
/// for Options::max_seeds seeds is taken at once.
/// @throws DeviceError where there is no device, or its memory is too small.
std::unique_ptr<Backend> MakeCudaBackend(const Options& options);

}  // namespace livemvs
