#pragma once

#include <cstddef>
#include <cstdint>

#include "livemvs/core/seed.h"

namespace livemvs {

/// A seed at its birth.
struct NewSeed {
  Interval<float> interval;
  float bearing_x;
  float bearing_y;
  const std::uint8_t* patch;  ///< Centre pixel in the grey image ...
  std::ptrdiff_t stride;      ///< ... whose rows are this far apart.
};

/// What is known of a seed, but for its patch.
struct SeedState {
  Interval<float> interval;
  float bearing_x;
  float bearing_y;
  Posterior<float> posterior;
  SeedCounts counts;
  Fate fate;
};

/// A seed that has ended.
struct EndedSeed {
  std::uint32_t slot;
  SeedState seed;
  std::uint8_t patch[kPatchPixels];  ///< Row-major.
};

}  // namespace livemvs
