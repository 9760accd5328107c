#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "livemvs/io/frame_source.h"

namespace livemvs {

/// Finds the pictures of a live source that would do harm: drivers repeat pictures, and clocks
/// jump.
class FrameGate {
 public:
  enum class Verdict {
    kGood,
    kOutOfOrder,  ///< Not later than the one before.
    kDuplicate,   ///< Pixel for pixel the one before, whatever its time says.
    kOtherSize,   ///< Not of the size of the first.
  };

  /// Pictures that are not good leave no trace here.
  Verdict Judge(const SourceFrame& frame);

 private:
  std::optional<double> last_time_;
  std::shared_ptr<const Picture> last_picture_;
};

}  // namespace livemvs
