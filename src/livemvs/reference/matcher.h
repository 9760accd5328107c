#pragma once

#include "livemvs/reference/algorithm1.h"

namespace livemvs::reference {

/// Distance along the seed's unit bearing at the coordinate mu of its interval [scene].
double DepthAt(const Options& options, const Seed& seed, double mu);

/// The grey level between four pixels, of which none may be outside.
double Bilinear(const ImageView<std::uint8_t>& image, const Eigen::Vector2d& p);

}  // namespace livemvs::reference
