#pragma once

#include <cstddef>
#include <cstdint>

#include "livemvs/core/seed.h"

namespace livemvs {

/// The state of all seeds, one array per quantity; entry i of each belongs to seed i. 61 bytes per
/// seed, and one for its fate.
struct SeedColumns {
  float* mu;
  float* sigma2;
  float* a;
  float* b;
  float* c0;         ///< Interval: coordinate at mu = 0 ...
  float* c1;         ///< ... and at mu = 1.
  float* bearing_x;  ///< X / Z of the seed's ray in its reference camera.
  float* bearing_y;
  std::uint8_t* patch;  ///< kPatchPixels each, row-major.
  SeedCounts* counts;
  Fate* fate;
};

inline constexpr std::size_t kBytesPerSeed =
    8 * sizeof(float) + kPatchPixels + sizeof(SeedCounts) + sizeof(Fate);
static_assert(kBytesPerSeed <= 64);

}  // namespace livemvs
