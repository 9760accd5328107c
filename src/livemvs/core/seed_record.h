#pragma once

#include <cstdint>

#include "livemvs/core/seed.h"

namespace livemvs {

/// The life of one seed in brief: where it was planted and what became of it. What false
/// convergence is measured from.
struct SeedRecord {
  std::int64_t birth_frame = 0;  ///< Index of the frame it was planted in ...
  float x = 0;                   ///< ... and its place there, in pixels of level 0 [px].
  float y = 0;
  std::int64_t end_frame = 0;  ///< Index of the frame in which it ended; of the last, if it lives.
  Fate fate = Fate::kAlive;    ///< kAlive: still undecided when the run ended. Never kRemoved.
  std::uint16_t views = 0;     ///< Frames whose measurement agreed.
  float depth = 0;             ///< Along the unit bearing [scene]; 0: the posterior has none.
  float sigma = 0;             ///< Its standard deviation [scene]; 0 where the depth is.
  std::uint8_t level = 0;      ///< Of the pyramid it lived on; x and y are of level 0.
};

}  // namespace livemvs
