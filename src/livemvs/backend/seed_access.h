#pragma once

#include <cstddef>
#include <cstring>

#include "livemvs/backend/seed_columns.h"
#include "livemvs/backend/seed_state.h"
#include "livemvs/core/platform.h"

namespace livemvs {

// What stores of seeds do with one of them, on the host and on devices.

/// The state of seed i.
LIVEMVS_HD inline SeedState StateOf(const SeedColumns& s, std::size_t i) {
  return {{s.c0[i], s.c1[i]},
          s.bearing_x[i],
          s.bearing_y[i],
          {s.mu[i], s.sigma2[i], s.a[i], s.b[i]},
          s.counts[i],
          s.fate[i]};
}

/// Seed i, which has ended.
LIVEMVS_HD inline EndedSeed EndOf(const SeedColumns& s, std::size_t i) {
  EndedSeed ended = {static_cast<std::uint32_t>(i), StateOf(s, i), {}};
  std::memcpy(ended.patch, s.patch + i * kPatchPixels, kPatchPixels);
  return ended;
}

/// Lets a newborn seed begin in slot i with that posterior.
LIVEMVS_HD inline void StartSeed(const SeedColumns& s,
                                 std::size_t i,
                                 const NewSeed& seed,
                                 const Posterior<float>& prior) {
  s.mu[i] = prior.mu;
  s.sigma2[i] = prior.sigma2;
  s.a[i] = prior.a;
  s.b[i] = prior.b;
  s.c0[i] = seed.interval.c0;
  s.c1[i] = seed.interval.c1;
  s.bearing_x[i] = seed.bearing_x;
  s.bearing_y[i] = seed.bearing_y;
  for (int r = 0; r < kPatchSize; ++r) {
    std::memcpy(s.patch + i * kPatchPixels + r * kPatchSize,
                seed.patch + (r - kPatchRadius) * seed.stride - kPatchRadius,
                kPatchSize);
  }
  s.counts[i] = {0, 0, 0};
  s.fate[i] = Fate::kAlive;
}

/// Copies seed i to slot j, but for its patch.
LIVEMVS_HD inline void CopySeed(const SeedColumns& from,
                                std::size_t i,
                                const SeedColumns& to,
                                std::size_t j) {
  to.mu[j] = from.mu[i];
  to.sigma2[j] = from.sigma2[i];
  to.a[j] = from.a[i];
  to.b[j] = from.b[i];
  to.c0[j] = from.c0[i];
  to.c1[j] = from.c1[i];
  to.bearing_x[j] = from.bearing_x[i];
  to.bearing_y[j] = from.bearing_y[i];
  to.counts[j] = from.counts[i];
  to.fate[j] = from.fate[i];
}

}  // namespace livemvs
