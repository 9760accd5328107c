#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

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
};

/// Copies a newborn's patch, row by row, to kPatchPixels bytes.
inline void CopyPatch(const NewSeed& seed, std::uint8_t* out) {
  for (int r = 0; r < kPatchSize; ++r) {
    std::memcpy(out + r * kPatchSize,
                seed.patch + (r - kPatchRadius) * seed.stride - kPatchRadius,
                kPatchSize);
  }
}

/// @throws std::length_error where `more` seeds beside those that there are exceed the capacity.
inline void CheckRoom(std::size_t seeds, std::size_t more, std::size_t capacity) {
  if (more <= capacity - seeds) return;
  throw std::length_error(std::to_string(more) + " new seeds do not fit: " + std::to_string(seeds) +
                          " of " + std::to_string(capacity) + " slots are in use");
}

}  // namespace livemvs
