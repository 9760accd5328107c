#pragma once

#include <cmath>
#include <cstddef>

#include "livemvs/backend/seed_columns.h"
#include "livemvs/core/epipolar.h"
#include "livemvs/core/options.h"
#include "livemvs/core/platform.h"

namespace livemvs {

/// Pictures wider or higher than this are not sampled on warped grids, whose places are fixed-point
/// numbers [px].
inline constexpr int kMostPixelsWarped = 32'000;

/// Whether the patches of a group look turned or scaled enough in the current image for the
/// sampling grid to follow: decided once for the group, on the scale of a living seed from its
/// middle on, or else before it.
class WarpRule {
 public:
  explicit WarpRule(const Options& options)
      : coordinate_(options.coordinate),
        turns_(options.warp_roll_deg > 0),
        least_roll_cos_(std::cos(options.warp_roll_deg * static_cast<float>(M_PI / 180))),
        scale_(options.warp_scale) {}

  static bool Allows(int width, int height) {
    return width <= kMostPixelsWarped && height <= kMostPixelsWarped;
  }

  bool Turned(const RelativeView<float>& view) const {
    return turns_ && view.roll_cos < least_roll_cos_;
  }

  /// For the group's seed in slot i.
  LIVEMVS_HD inline bool Scaled(const RelativeView<float>& view,
                                const SeedColumns& s,
                                std::size_t i) const {
    if (scale_ <= 0) return false;
    const Projection<float> p = ProjectSeed<PinholeModel>(
        view, coordinate_, {s.c0[i], s.c1[i]}, s.bearing_x[i], s.bearing_y[i], s.mu[i]);
    return p.visible && (p.scale > scale_ || p.scale < 1 / scale_);
  }

 private:
  DepthCoordinate coordinate_;
  bool turns_;
  float least_roll_cos_;
  float scale_;
};

}  // namespace livemvs
