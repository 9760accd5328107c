#include "livemvs/core/frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace livemvs {
namespace {

std::uint8_t ToByte(double v) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0)));
}

}  // namespace

Rgb Picture::ColorAt(int x, int y) const {
  assert(x >= 0 && y >= 0 && x < width() && y < height());
  const double luma = full_range ? grey(x, y) : (grey(x, y) - 16) * (255.0 / 219.0);
  if (cb.empty()) return {ToByte(luma), ToByte(luma), ToByte(luma)};
  const double gain = full_range ? 1 : 255.0 / 224.0;
  const int cx = std::min(x >> chroma_shift_x, cb.width() - 1);
  const int cy = std::min(y >> chroma_shift_y, cb.height() - 1);
  const double u = gain * (cb(cx, cy) - 128);
  const double v = gain * (cr(cx, cy) - 128);
  // ITU-R BT.601 and BT.709: Kr, Kb of the luma sum give the four coefficients.
  const double kr = matrix == YuvMatrix::kBt601 ? 0.299 : 0.2126;
  const double kb = matrix == YuvMatrix::kBt601 ? 0.114 : 0.0722;
  const double r = luma + 2 * (1 - kr) * v;
  const double b = luma + 2 * (1 - kb) * u;
  const double g = (luma - kr * r - kb * b) / (1 - kr - kb);
  return {ToByte(r), ToByte(g), ToByte(b)};
}

}  // namespace livemvs
