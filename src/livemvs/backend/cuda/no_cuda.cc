// In place of the CUDA backend where it is not built.

#include "livemvs/backend/cuda/cuda_backend.h"

namespace livemvs {
namespace {

constexpr const char* kNotBuilt =
    "livemvs was built without CUDA (build it where nvcc is found, see README)";

}  // namespace

CudaDevices FindCudaDevices() { return {{}, kNotBuilt}; }

std::unique_ptr<Backend> MakeCudaBackend(const Options&) {
  throw DeviceError(std::string("GPU: ") + kNotBuilt);
}

}  // namespace livemvs
