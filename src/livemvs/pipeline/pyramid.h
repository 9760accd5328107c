#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "livemvs/core/image.h"

namespace livemvs {

/// A picture and its halves: level 0 is the picture itself, and a pixel of level l + 1 is the mean
/// of four of level l (AtLevel() is its camera). Buffers are kept between pictures. Move-only.
class Pyramid {
 public:
  /// Points to `grey`, which must outlive the use, and fills `levels` - 1 further levels; levels of
  /// less than 16 pixels a side are left out.
  void Build(const Image<std::uint8_t>& grey, int levels);

  std::span<const ImageView<std::uint8_t>> levels() const { return views_; }

 private:
  std::vector<Image<std::uint8_t>> halves_;
  std::vector<ImageView<std::uint8_t>> views_;
};

}  // namespace livemvs
