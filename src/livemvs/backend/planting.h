#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/plant_rule.h"
#include "livemvs/core/image.h"
#include "livemvs/core/options.h"
#include "livemvs/core/posterior.h"

namespace livemvs {

// What all backends do on the host to plant.

/// The posterior of a newborn seed, [VH11] Sec. 4.2: 99 % of it lie on the interval.
Posterior<float> PriorOf(const Options& options);

/// A frame with that camera at one level of its pyramid.
/// @param grey  The picture; what it points to may be elsewhere than on the host.
PlantView MakePlantView(const Options& options,
                        const Planting& planting,
                        int level,
                        const ImageView<std::uint8_t>& grey);

/// Where candidates are sought in it: in the part of the picture onto which the scene's box
/// projects.
CandidateRule MakeCandidateRule(const Options& options, const Planting& planting, int level);

/// Number of candidates by phase.
using PhaseCounts = std::array<std::size_t, kPhases>;

/// Takes the next share of `wanted` candidates, or what there is of them, from those that are left.
Share TakeShare(std::size_t wanted, PhaseCounts* left);

/// Fills `free` slots with the seeds of candidates, and returns how many it planted. Some of those
/// that are offered are refused: what they leave is offered to others. Where most are refused, as
/// outside of the range, more are offered: each round looks at the whole picture.
/// @param plant  plant(share, free) offers a share, row by row, until `free` more seeds are
///               planted, and returns how many were.
template <typename F>
std::size_t PlantInRounds(PhaseCounts left, std::size_t free, const F& plant) {
  // Offers per seed that is still wanted: somewhat fewer than the last round suggests, so that the
  // last of them are spread over the whole picture; many more where it planted none.
  constexpr double kCautious = 0.8, kBolder = 8, kMostOffers = 1e6;
  std::size_t planted = 0;
  double offers_per_seed = 1;
  while (planted < free) {
    const auto wanted =
        static_cast<std::size_t>(offers_per_seed * static_cast<double>(free - planted));
    const Share share = TakeShare(wanted, &left);
    if (share.size == 0) break;
    const std::size_t taken = plant(share, free - planted);
    planted += taken;
    const double next =
        taken > 0 ? kCautious * static_cast<double>(share.size) / static_cast<double>(taken)
                  : kBolder * offers_per_seed;
    offers_per_seed = std::clamp(next, 1.0, kMostOffers);
  }
  return planted;
}

}  // namespace livemvs
