#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "livemvs/core/image.h"
#include "livemvs/core/platform.h"

namespace livemvs {

/// A picture of marks: 1 where something is.
struct MarkImage {
  std::uint8_t* data;
  int width, height;
  std::ptrdiff_t stride;

  ImageView<std::uint8_t> view() const { return {data, width, height, stride}; }
};

/// Sets a pixel to 1. Others may do so too.
LIVEMVS_HD inline void SetMark(std::uint8_t* pixel) {
#if defined(__CUDA_ARCH__)
  *pixel = 1;
#else
  std::atomic_ref<std::uint8_t>(*pixel).store(1, std::memory_order_relaxed);
#endif
}

}  // namespace livemvs
