#pragma once

#include <algorithm>
#include <cstdint>

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

  /// Calls f(x, y, phase) for each of the phases [first, last], row by row; f may take it.
  template <typename F>
  void ForEach(int first, int last, const F& f) const {
    for (int row = grid_.row; row < grid_.row + grid_.rows; ++row)
      ForEachInRow(row, first, last, f);
  }

  /// The pixel is a candidate no longer.
  void Take(int x, int y) { phase_(x, y) = 0; }

 private:
  // Of a row of the grid. The phases repeat every kCell columns: those that are not asked for are
  // not looked at.
  template <typename F>
  void ForEachInRow(int row, int first, int last, const F& f) const {
    int columns[kCell], phases[kCell], wanted = 0;
    for (int i = 0; i < std::min(kCell, grid_.columns); ++i) {
      const int phase = PhaseOf(grid_.column + i, row);
      if (phase < first || phase > last) continue;
      columns[wanted] = grid_.column + i;
      phases[wanted++] = phase;
    }
    if (wanted == 0) return;
    const int y = row * grid_.spacing, end = (grid_.column + grid_.columns) * grid_.spacing;
    const std::uint8_t* pixels = phase_.Row(y);
    for (int cell = 0; cell < end; cell += kCell * grid_.spacing) {
      for (int i = 0; i < wanted; ++i) {
        const int x = cell + columns[i] * grid_.spacing;
        if (x < end && pixels[x] > 0) f(x, y, phases[i]);
      }
    }
  }

  CandidateGrid grid_{};
  Image<std::uint8_t> phase_;  // 1 + phase, or 0
  PhaseCounts count_{};
};

}  // namespace livemvs
