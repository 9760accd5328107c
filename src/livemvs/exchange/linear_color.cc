#include "livemvs/exchange/linear_color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace livemvs {
namespace {

/// The linear values of the 256 levels of sRGB, in ascending order; the last is 65535.
const std::array<std::uint16_t, 256>& LinearLevels() {
  static const std::array<std::uint16_t, 256> kTable = [] {
    std::array<std::uint16_t, 256> table{};
    for (int i = 0; i < 256; ++i) {
      const double s = i / 255.0;  // IEC 61966-2-1
      const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
      table[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(std::lround(65535 * linear));
    }
    return table;
  }();
  return kTable;
}

}  // namespace

std::uint16_t LinearFromSrgb(std::uint8_t value) { return LinearLevels()[value]; }

std::uint8_t SrgbFromLinear(std::uint16_t value) {
  const std::array<std::uint16_t, 256>& levels = LinearLevels();
  return static_cast<std::uint8_t>(std::ranges::lower_bound(levels, value) - levels.begin());
}

}  // namespace livemvs
