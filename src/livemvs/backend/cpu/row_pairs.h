#pragma once

#include <cstdint>

#include "livemvs/core/image.h"

namespace livemvs {

/// An image with each pixel beside the one below it: entry (x, y) holds grey(x, y) - 128 in its
/// lower byte and grey(x, y + 1) - 128 in its upper one, both signed. Two neighbouring entries are
/// the four pixels of a bilinear interpolation in one word. The last row is paired with itself.
class RowPairs {
 public:
  /// Makes them of an image; threads are those of the caller's arena.
  void Build(const ImageView<std::uint8_t>& image);

  ImageView<std::uint16_t> view() const { return pairs_.view(); }

 private:
  Image<std::uint16_t> pairs_;
};

}  // namespace livemvs
