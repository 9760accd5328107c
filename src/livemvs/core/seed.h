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
  kOneSided,      ///< Converged, but a half of its patch does not match there (min_side_ncc).
  kTakenOut,      ///< Converged, but its point was taken out of the finished cloud.
  kRemoved        ///< Dealt with; its slot is free.
};

/// The small counts that a seed carries.
struct SeedCounts {
  std::uint16_t age;    ///< Frames met that told something, or had the parallax to do so.
  std::uint8_t views;   ///< Frames whose measurement agreed; saturates at 255.
  std::uint8_t unseen;  ///< Frames met in a row that were out of view; saturates at 255.
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
  const T sigma_c = Sqrt(sigma2) * Abs(length);
  if (coordinate == DepthCoordinate::kDepth) return {c, sigma_c};
  const T depth = T(1) / c;
  return {depth, sigma_c * depth * depth};
}

/// Z_max - Z_min of a seed's interval [scene].
template <typename T>
LIVEMVS_HD inline T DepthRange(DepthCoordinate coordinate, const Interval<T>& interval) {
  if (coordinate == DepthCoordinate::kDepth) return Abs(interval.c1 - interval.c0);
  return Abs(T(1) / interval.c0 - T(1) / interval.c1);
}

/// Variance of mu with the error that all matches share: `step` is the change of mu per pixel of
/// the current frame, so that the term shrinks as the baseline grows.
template <typename T>
LIVEMVS_HD inline T TotalVariance(T sigma2, T bias2_px, T step) {
  return sigma2 + bias2_px * step * step;
}

/// SeedCounts as numbers that the mathematics computes with.
template <typename T>
struct CountsOf {
  T age;
  T views;
  T unseen;
};

/// Decides the outcome of a seed after a frame, [VH11] Sec. 4.3. Returns the number of the Fate.
/// @param total_sigma2  TotalVariance() in a frame that gave a match; negative in others, in which
///                      no seed is converted.
/// @param pixel_width   Width of a pixel at unit depth, 1 / f of the reference camera.
template <typename T>
LIVEMVS_HD inline T JudgeNumber(const Options& options,
                                const OutlierRule& is_outlier,
                                const Interval<T>& interval,
                                const Posterior<T>& q,
                                const CountsOf<T>& counts,
                                T total_sigma2,
                                float pixel_width) {
  const auto number = [](Fate f) { return T(static_cast<float>(f)); };
  const auto reaches = [](T count, int limit) { return count >= T(static_cast<float>(limit)); };
  T fate = number(Fate::kAlive);
  if (options.max_unseen > 0) {
    fate = Select(reaches(counts.unseen, options.max_unseen), number(Fate::kUnseen), fate);
  }
  if (options.max_age > 0) {
    fate = Select(reaches(counts.age, options.max_age), number(Fate::kAged), fate);
  }
  const DepthEstimate<T> z = DepthOf(options.coordinate, interval, q.mu, total_sigma2);
  const MaskOf<T> sharp =
      (z.sigma < T(options.epsilon_range) * DepthRange(options.coordinate, interval)) |
      (z.sigma < T(options.epsilon_px * pixel_width) * z.depth);
  const MaskOf<T> told = total_sigma2 >= T(0), agreeing = InlierRatio(q) > T(options.eta_inlier);
  const MaskOf<T> seen = reaches(counts.views, options.min_views);
  const MaskOf<T> converged = told & agreeing & seen & sharp;
  // Beyond its interval is where the user did not want points.
  const MaskOf<T> wanted = (q.mu >= T(0)) & (q.mu <= T(1));
  fate = Select(
      converged, Select(wanted, number(Fate::kConverged), number(Fate::kLeftInterval)), fate);
  fate = Select(is_outlier(q.a, q.b), number(Fate::kOutlier), fate);
  return Select((q.mu > T(-0.1F)) & (q.mu < T(1.1F)), fate, number(Fate::kLeftInterval));
}

/// JudgeNumber() of one seed.
LIVEMVS_HD inline Fate Judge(const Options& options,
                             const OutlierRule& is_outlier,
                             const Interval<float>& interval,
                             const Posterior<float>& q,
                             const SeedCounts& counts,
                             float total_sigma2,
                             float pixel_width) {
  return static_cast<Fate>(static_cast<int>(JudgeNumber<float>(options,
                                                               is_outlier,
                                                               interval,
                                                               q,
                                                               {static_cast<float>(counts.age),
                                                                static_cast<float>(counts.views),
                                                                static_cast<float>(counts.unseen)},
                                                               total_sigma2,
                                                               pixel_width)));
}

}  // namespace livemvs
