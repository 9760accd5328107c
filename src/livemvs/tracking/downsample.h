#pragma once

#include <cstdint>

#include "livemvs/core/image.h"

namespace livemvs {

/// The picture with each square of factor x factor pixels made one, their mean; what is left over
/// at the right and lower border is dropped. factor: 1 to 16.
Image<std::uint8_t> Downsample(ImageView<std::uint8_t> image, int factor);

}  // namespace livemvs
