#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "livemvs/core/image.h"
#include "livemvs/tracking/board.h"

namespace livemvs {

struct DetectedMarker {
  int index = 0;                           ///< Into MarkersOf(board).
  std::array<Eigen::Vector2d, 4> corners;  ///< [px], in the order of BoardMarker::corners.
};

/// Finds a board's markers anywhere in a picture. Not thread-safe.
class MarkerDetector {
 public:
  /// @param detect_width  Pictures at least twice as wide are searched at half their size, and so
  ///                      on. [px]
  MarkerDetector(const Board& board, int detect_width);
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;
  MarkerDetector& operator=(MarkerDetector&&) noexcept;

  /// Each marker at most once; one that seems to be in two places is in none.
  std::vector<DetectedMarker> Detect(ImageView<std::uint8_t> image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livemvs
