#include "livemvs/eval/color_ramp.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace livemvs {
namespace {

std::array<float, 256> MakeLinearTable() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double v = static_cast<double>(i) / 255;
    table[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return table;
}

}  // namespace

Eigen::Vector3f LinearFromSrgb(Rgb color) {
  static const std::array<float, 256> table = MakeLinearTable();
  return {table[color[0]], table[color[1]], table[color[2]]};
}

Rgb SrgbFromLinear(const Eigen::Vector3f& light) {
  Rgb color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double v = std::clamp(static_cast<double>(light[static_cast<int>(c)]), 0.0, 1.0);
    const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
    color[c] = static_cast<std::uint8_t>(std::lround(255 * s));
  }
  return color;
}

Rgb RampColor(double t) {
  constexpr std::array<Rgb, 6> kStops = {{{52, 38, 110},
                                          {48, 84, 150},
                                          {32, 128, 146},
                                          {58, 168, 116},
                                          {156, 200, 72},
                                          {250, 222, 64}}};
  // In this order, NaN gives 0.
  const double at = (t > 0 ? std::min(t, 1.0) : 0.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  Rgb color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double a = kStops[below][c], b = kStops[below + 1][c];
    color[c] =
        static_cast<std::uint8_t>(std::lround(a + (at - static_cast<double>(below)) * (b - a)));
  }
  return color;
}

}  // namespace livemvs
