#pragma once

#include <memory>

#include "livemvs/core/frame.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/calibrator.h"

namespace livemvs {

/// Finds the corners of a board in single pictures, without knowledge of the camera: what a
/// Calibrator takes. Not thread-safe.
class CornerSource {
 public:
  explicit CornerSource(const Board& board);
  ~CornerSource();
  CornerSource(CornerSource&&) noexcept;
  CornerSource& operator=(CornerSource&&) noexcept;

  /// No observations: the board is not seen.
  CalibrationView Find(const Picture& picture);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livemvs
