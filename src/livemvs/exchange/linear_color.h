#pragma once

#include <cstdint>

namespace livemvs {

/// The value of a linear colour, 0 ... 65535, of one in sRGB.
std::uint16_t LinearFromSrgb(std::uint8_t value);

/// Its inverse; values between are those of the next higher level.
std::uint8_t SrgbFromLinear(std::uint16_t value);

}  // namespace livemvs
