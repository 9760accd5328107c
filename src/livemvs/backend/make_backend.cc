#include "livemvs/backend/backend.h"
#include "livemvs/backend/cuda/cuda_backend.h"
#include "livemvs/core/log.h"

namespace livemvs {
namespace {

std::unique_ptr<Backend> MakeAnyBackend(const Options& options) {
  if (FindCudaDevices().devices.empty()) return MakeCpuBackend(options);
  try {
    return MakeCudaBackend(options);
  } catch (const DeviceError& e) {
    LogWarning(std::string(e.what()) + "; the CPU does it");
    return MakeCpuBackend(options);
  }
}

}  // namespace

std::unique_ptr<Backend> MakeBackend(const Options& options) {
  switch (options.backend) {
    case BackendChoice::kCuda:
      return MakeCudaBackend(options);
    case BackendChoice::kAuto:
      return MakeAnyBackend(options);
    case BackendChoice::kCpu:
      break;
  }
  return MakeCpuBackend(options);
}

}  // namespace livemvs
