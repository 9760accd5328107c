#pragma once

#include <cstdint>
#include <vector>

#include "livemvs/core/image.h"

namespace livemvs::synth {

/// A picture printed on a sheet about the origin: x to the right, y up. Its mean over any square is
/// exact (a summed-area table), so that it is sharp from near and does not flicker from afar.
class PrintedSheet {
 public:
  /// @param picture  0: ink, 255: paper.
  /// @param width    Of the sheet [m]; its height follows from the picture's shape.
  PrintedSheet(const Image<std::uint8_t>& picture, double width);

  double width() const { return width_; }    ///< [m]
  double height() const { return height_; }  ///< [m]

  /// Part of the paper that shows, 0 to 1, over a square of side `footprint` about (x, y). [m]
  float PaperAt(float x, float y, float footprint) const;

 private:
  double Sum(double column, double row) const;

  int columns_ = 0, rows_ = 0;  // [picture pixels]
  double width_ = 0, height_ = 0, per_metre_ = 0;
  std::vector<double> sums_;  // of all pixels above and left of a corner of pixels
};

}  // namespace livemvs::synth
