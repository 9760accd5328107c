#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "livemvs/core/frame.h"

namespace livemvs {

/// How poses may have been misread: the ways that files differ most.
enum class PoseReading { kAsIs, kInverse, kFlippedAxes, kInverseFlippedAxes };
inline constexpr std::size_t kPoseReadings = 4;

/// "as read", "inverted", ...
std::string ToString(PoseReading reading);

/// How well poses and pictures agree, by matches between frames that were found without the poses.
struct EpipolarReport {
  std::size_t matches = 0;
  /// Median distance of a match from its epipolar line [px] under each reading; 0 without matches.
  std::array<double, kPoseReadings> median_error_px{};
  PoseReading best = PoseReading::kAsIs;

  /// Whether there were matches enough to say anything.
  bool conclusive() const { return matches >= 40; }
  /// Whether another reading of the poses fits clearly better than the one in use.
  bool suggests_other() const {
    return conclusive() && best != PoseReading::kAsIs && median_error_px[0] > 1.5 &&
           median_error_px[static_cast<std::size_t>(best)] < 0.5 * median_error_px[0];
  }
};

/// Matches textured 11 x 11 patches by NCC between frames a few steps apart, within 32 px all
/// around and without use of the poses, and measures how far they lie from their epipolar lines.
/// @param frames  Consecutive frames, ten or more for a good answer; all of one size.
EpipolarReport CheckEpipolarConsistency(const std::vector<PosedFrame>& frames);

}  // namespace livemvs
