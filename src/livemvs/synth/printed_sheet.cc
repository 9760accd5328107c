#include "livemvs/synth/printed_sheet.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace livemvs::synth {

PrintedSheet::PrintedSheet(const Image<std::uint8_t>& picture, double width)
    : columns_(picture.width()), rows_(picture.height()), width_(width) {
  if (picture.empty() || !(width > 0)) {
    throw std::invalid_argument("a printed sheet needs a picture and a width");
  }
  per_metre_ = columns_ / width;
  height_ = rows_ / per_metre_;
  const std::size_t stride = static_cast<std::size_t>(columns_) + 1;
  sums_.assign(stride * (rows_ + 1), 0);
  for (int y = 0; y < rows_; ++y) {
    double row = 0;
    for (int x = 0; x < columns_; ++x) {
      row += picture(x, y) / 255.0;
      sums_[stride * (y + 1) + x + 1] = sums_[stride * y + x + 1] + row;
    }
  }
}

// The sum over the rectangle from the upper left corner, pixels being even squares.
double PrintedSheet::Sum(double column, double row) const {
  const double u = std::clamp(column, 0.0, static_cast<double>(columns_));
  const double v = std::clamp(row, 0.0, static_cast<double>(rows_));
  const int x = std::min(static_cast<int>(u), columns_ - 1);
  const int y = std::min(static_cast<int>(v), rows_ - 1);
  const double fx = u - x, fy = v - y;
  const std::size_t stride = static_cast<std::size_t>(columns_) + 1;
  const double* const at = &sums_[stride * y + x];
  return (1 - fy) * ((1 - fx) * at[0] + fx * at[1]) +
         fy * ((1 - fx) * at[stride] + fx * at[stride + 1]);
}

float PrintedSheet::PaperAt(float x, float y, float footprint) const {
  const double half = 0.5 * std::max<double>(footprint, 1e-6);
  const double left = (x - half + 0.5 * width_) * per_metre_;
  const double right = (x + half + 0.5 * width_) * per_metre_;
  const double top = (0.5 * height_ - y - half) * per_metre_;
  const double bottom = (0.5 * height_ - y + half) * per_metre_;
  const double sum = Sum(right, bottom) - Sum(left, bottom) - Sum(right, top) + Sum(left, top);
  return static_cast<float>(std::clamp(sum / ((right - left) * (bottom - top)), 0.0, 1.0));
}

}  // namespace livemvs::synth
