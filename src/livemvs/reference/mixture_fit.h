#pragma once

#include <span>

namespace livemvs::reference {

/// One depth measurement of a pixel, [VH11] Sec. 3.
struct DepthMeasurement {
  double x;     ///< Measured depth [scene].
  double tau2;  ///< Its variance if it is a good one [scene²].
};

/// A point estimate of depth and inlier ratio.
struct MixtureFit {
  double z = 0;               ///< Depth [scene].
  double inlier_ratio = 0.5;  ///< pi.
  double log_likelihood = 0;
  int iterations = 0;
};

/// Sum of log(pi N(x_n | Z, tau_n²) + (1 - pi) u), [VH11] Eq. (1).
double MixtureLogLikelihood(std::span<const DepthMeasurement> measurements,
                            double u,
                            double z,
                            double inlier_ratio);

/// Maximum likelihood of (Z, pi) by expectation maximisation, which [VH11] Sec. 3.1 tried first:
/// climbs from the start to a local maximum, not always the global one.
/// @param u      Density of outliers, > 0.
/// @param start  z and inlier_ratio in (0, 1) to start from.
MixtureFit FitMixtureByEm(std::span<const DepthMeasurement> measurements,
                          double u,
                          const MixtureFit& start);

}  // namespace livemvs::reference
