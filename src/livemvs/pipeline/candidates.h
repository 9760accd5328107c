#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "livemvs/core/image.h"

namespace livemvs {

/// Pixels [x0, x1) x [y0, y1).
struct PixelRect {
  int x0, y0, x1, y1;
};

/// What makes a pixel worth a seed.
struct CandidateRule {
  PixelRect rect;    ///< Keeps from the border what a patch needs.
  int spacing;       ///< Distance of neighbouring candidates [px].
  int cover_radius;  ///< Pixels as near to a mark are none; -1: marks do not count.
  float min_stddev;  ///< Of the grey levels of the patch.
};

/// The pixels of a picture where a seed may be planted, each with a phase: any number of the first
/// phases is spread evenly over the picture. Buffers are kept between frames.
class Candidates {
 public:
  static constexpr int kPhases = 16;

  /// @param marks  Of the picture's size: 1 where something is known already.
  void Find(const ImageView<std::uint8_t>& grey,
            const ImageView<std::uint8_t>& marks,
            const CandidateRule& rule);

  /// How many there are of each phase, but for those that were taken.
  const std::array<std::size_t, kPhases>& count() const { return count_; }

  /// Calls f(x, y, phase) for each, row by row; f may take it.
  template <typename F>
  void ForEach(const F& f) const {
    for (int y = rect_.y0; y < rect_.y1; ++y) ForEachInRow(y, f);
  }

  /// The pixel, of that phase, is a candidate no longer.
  void Take(int x, int y, int phase) {
    phase_(x, y) = 0;
    --count_[phase];
  }

 private:
  template <typename F>
  void ForEachInRow(int y, const F& f) const {
    constexpr int kStep = 8;  // rows may be read beyond their end
    const std::uint8_t* row = phase_.Row(y);
    for (int x = rect_.x0; x < rect_.x1; x += kStep) {
      std::uint64_t some = 0;
      std::memcpy(&some, row + x, sizeof some);
      if (some == 0) continue;
      for (int i = x; i < std::min(x + kStep, rect_.x1); ++i) {
        if (row[i] > 0) f(i, y, row[i] - 1);
      }
    }
  }

  PixelRect rect_{};
  Image<std::uint8_t> phase_;  // 1 + phase, or 0
  std::array<std::size_t, kPhases> count_{};
};

}  // namespace livemvs
