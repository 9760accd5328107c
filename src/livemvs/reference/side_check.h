#pragma once

#include "livemvs/reference/algorithm1.h"

namespace livemvs::reference {

/// Whether every half of the seed's patch that has texture matches where the posterior mean puts it
/// (Options::min_side_ncc). The patch's pixels are projected one by one, on the plane at the mean's
/// depth that faces the reference camera. True also where one of them is not in the picture, a
/// pixel from its border.
bool SidesMatch(const Options& options, const Seed& seed, const Meeting& current);

}  // namespace livemvs::reference
