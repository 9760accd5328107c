#pragma once

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cpu/kernels.h"
#include "livemvs/backend/cuda/cuda_backend.h"

namespace livemvs::testing_support {

/// Of the kinds of backends, the one that needs a device.
inline constexpr const char* kCuda = "CUDA";

/// The CPU's instruction sets that can be tested here, and the GPU.
inline std::vector<std::string> BackendKinds() {
  std::vector<std::string> kinds;
  for (const NamedKernel& kernel : UsableKernels()) kinds.emplace_back(kernel.name);
  kinds.emplace_back(kCuda);
  return kinds;
}

/// Why a kind cannot be tested here; empty: it can.
inline std::string TroubleWith(const std::string& kind) {
  if (kind != kCuda) return {};
  const CudaDevices found = FindCudaDevices();
  return found.devices.empty() ? found.trouble : std::string();
}

inline std::unique_ptr<Backend> MakeBackendOf(const std::string& kind, const Options& options) {
  if (kind == kCuda) return MakeCudaBackend(options);
  ::setenv(kInstructionsVariable, kind.c_str(), 1);
  std::unique_ptr<Backend> backend = MakeCpuBackend(options);
  ::unsetenv(kInstructionsVariable);
  return backend;
}

/// A kind as the name of a test.
inline std::string TestNameOf(std::string kind) {
  std::erase_if(kind, [](unsigned char c) { return !std::isalnum(c); });
  return kind;
}

/// A picture whose pixels are the means of squares of `side` pixels; an odd rest is left out.
inline Image<std::uint8_t> Shrunk(const Image<std::uint8_t>& grey, int side) {
  Image<std::uint8_t> smaller(grey.width() / side, grey.height() / side);
  for (int y = 0; y < smaller.height(); ++y) {
    for (int x = 0; x < smaller.width(); ++x) {
      int sum = side * side / 2;
      for (int k = 0; k < side * side; ++k) sum += grey(side * x + k % side, side * y + k / side);
      smaller(x, y) = static_cast<std::uint8_t>(sum / (side * side));
    }
  }
  return smaller;
}

}  // namespace livemvs::testing_support
