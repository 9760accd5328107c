#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "livemvs/backend/planting.h"
#include "livemvs/core/image.h"

namespace livemvs {

/// The pixels of a picture where a seed may be planted, each with its phase. Buffers are kept
/// between frames.
class Candidates {
 public:
  /// @param marks  Of the picture's size: 1 where something is known already.
  void Find(const ImageView<std::uint8_t>& grey,
            const ImageView<std::uint8_t>& marks,
            const CandidateRule& rule);

  /// How many were found of each phase.
  const PhaseCounts& count() const { return count_; }

  /// Calls f(x, y, phase) for each, row by row; f may take it.
  template <typename F>
  void ForEach(const F& f) const {
    for (int y = rect_.y0; y < rect_.y1; ++y) ForEachInRow(y, f);
  }

  /// The pixel is a candidate no longer.
  void Take(int x, int y) { phase_(x, y) = 0; }

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
  PhaseCounts count_{};
};

}  // namespace livemvs
