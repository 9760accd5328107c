#pragma once

#include <Eigen/Core>

#include "livemvs/core/frame.h"

namespace livemvs {

/// Light of an 8-bit sRGB colour, linear, in [0, 1].
Eigen::Vector3f LinearFromSrgb(Rgb color);

/// 8-bit sRGB of linear light; clamped.
Rgb SrgbFromLinear(const Eigen::Vector3f& light);

/// A ramp from dark blue over green to yellow, even in lightness, for t in [0, 1]; clamped, NaN as
/// 0.
Rgb RampColor(double t);

}  // namespace livemvs
