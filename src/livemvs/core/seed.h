#pragma once

#include <cstdint>

#include "livemvs/core/epipolar.h"
#include "livemvs/core/options.h"
#include "livemvs/core/platform.h"
#include "livemvs/core/posterior.h"

namespace livemvs {

/// Side of the square reference patch W [px].
inline constexpr int kPatchSize = 5;
inline constexpr int kPatchRadius = kPatchSize / 2;
inline constexpr int kPatchPixels = kPatchSize * kPatchSize;

/// What becomes of a seed, [VH11] Sec. 4.3.
enum class Fate : std::uint8_t {
  kAlive,
  kConverged,     ///< Criterion 2: turned into a point.
  kOutlier,       ///< Criterion 1: the inlier ratio is too low with certainty.
  kAged,          ///< Told enough times, and still not converged.
  kUnseen,        ///< Out of view for too long.
  kLeftInterval,  ///< The posterior mean wandered off the ray's interval.
  kRemoved        ///< Dealt with; its slot is free.
};

/// The small counts that a seed carries.
struct SeedCounts {
  std::uint16_t age;    ///< Frames that told something, or had the parallax to do so.
  std::uint8_t views;   ///< Frames whose measurement agreed; saturates at 255.
  std::uint8_t unseen;  ///< Consecutive frames out of view; saturates at 255.
};

/// Depth of a seed and its uncertainty, both along the unit bearing [scene].
template <typename T>
struct DepthEstimate {
  T depth;
  T sigma;
};

template <typename T>
LIVEMVS_HD inline DepthEstimate<T> DepthOf(DepthCoordinate coordinate,
                                           const Interval<T>& interval,
                                           T mu,
                                           T sigma2) {
  const T length = interval.c1 - interval.c0;
  const T c = interval.c0 + mu * length;
  const T sigma_c = std::sqrt(sigma2) * std::abs(length);
  if (coordinate == DepthCoordinate::kDepth) return {c, sigma_c};
  const T depth = T(1) / c;
  return {depth, sigma_c * depth * depth};
}

/// Z_max - Z_min of a seed's interval [scene].
template <typename T>
LIVEMVS_HD inline T DepthRange(DepthCoordinate coordinate, const Interval<T>& interval) {
  if (coordinate == DepthCoordinate::kDepth) return std::abs(interval.c1 - interval.c0);
  return std::abs(T(1) / interval.c0 - T(1) / interval.c1);
}

/// Variance of mu with the error that all matches share: `step` is the change of mu per pixel of
/// the current frame, so that the term shrinks as the baseline grows.
LIVEMVS_HD inline float TotalVariance(float sigma2, float bias2_px, float step) {
  return sigma2 + bias2_px * step * step;
}

/// Decides the outcome of a seed after a frame, [VH11] Sec. 4.3.
/// @param total_sigma2  TotalVariance() in a frame that gave a match; negative in others, in which
/// no
///                      seed is converted.
/// @param pixel_width   Width of a pixel at unit depth, 1 / f of the reference camera.
LIVEMVS_HD inline Fate Judge(const Options& options,
                             const OutlierRule& is_outlier,
                             const Interval<float>& interval,
                             const Posterior<float>& q,
                             const SeedCounts& counts,
                             float total_sigma2,
                             float pixel_width) {
  if (!(q.mu > -0.1F && q.mu < 1.1F)) return Fate::kLeftInterval;
  if (is_outlier(q.a, q.b)) return Fate::kOutlier;
  if (total_sigma2 >= 0 && InlierRatio(q) > options.eta_inlier &&
      counts.views >= options.min_views) {
    const DepthEstimate<float> z = DepthOf(options.coordinate, interval, q.mu, total_sigma2);
    if (z.sigma < options.epsilon_range * DepthRange(options.coordinate, interval) ||
        z.sigma < options.epsilon_px * pixel_width * z.depth) {
      // Beyond its interval is where the user did not want points.
      return q.mu >= 0 && q.mu <= 1 ? Fate::kConverged : Fate::kLeftInterval;
    }
  }
  if (options.max_age > 0 && counts.age >= options.max_age) return Fate::kAged;
  if (options.max_unseen > 0 && counts.unseen >= options.max_unseen) return Fate::kUnseen;
  return Fate::kAlive;
}

}  // namespace livemvs
