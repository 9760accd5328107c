#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "livemvs/core/posterior.h"
#include "livemvs/reference/mixture_fit.h"
#include "livemvs/reference/ncc_curve.h"
#include "livemvs/reference/posterior.h"
#include "livemvs/synth/scene.h"
#include "photo_set.h"

namespace livemvs::experiments {

/// Which local maxima are measurements, in which [VH11] leaves a choice.
enum class Selection {
  kLargest,  ///< The largest of each view, as in Algorithm 1, step 2b.
  kHigh,     ///< Those of kMinNcc or more: a maximum of -0.5 says that patches are unlike.
  kAll
};
inline constexpr double kMinNcc = 0.6;

/// The paper's depth sensor, [VH11] Sec. 3: a pixel, and the local maxima x_1 ... x_N of its NCC
/// curves in neighbouring views.
struct PixelSensor {
  int view = 0, x = 0, y = 0;
  reference::RayPatch ray;
  double z_min = 0, z_max = 0;  ///< Stretch of the ray in the box [scene].
  double z_true = 0;            ///< 0: not known.
  double visible_share = 0;     ///< Of the neighbours, those that see the surface; with z_true.
  std::vector<std::vector<reference::NccMaximum>> maxima;  ///< Of each neighbour.
  /// Those that count, in the order of the neighbours; tau is 1 px.
  std::vector<reference::DepthMeasurement> measurements;

  double range() const { return z_max - z_min; }
  /// Density of outliers, Eq. (1).
  double u() const { return 1 / range(); }
};

/// The pixel's ray without measurements, or nothing where it misses the box or has no contrast.
/// With a scene, also its truth, and nothing where the ray hits no surface in the box.
std::optional<PixelSensor> PlaceSensor(
    const PhotoSet& photos, const SyntheticScene* scene, int view, int x, int y);

/// Collects the local maxima in these views within [z_min, z_max]; those of kHigh become
/// measurements.
void Observe(const PhotoSet& photos, const std::vector<int>& neighbours, PixelSensor* sensor);

/// Makes measurements of the maxima that are selected.
void Measure(Selection selection, PixelSensor* sensor);

/// Puts the measurements into a random order, the same for the same pixel.
void Shuffle(PixelSensor* sensor);

/// The share of the neighbours that see the true surface point.
double VisibleShare(const PhotoSet& photos,
                    const SyntheticScene& scene,
                    const std::vector<int>& neighbours,
                    const PixelSensor& sensor);

/// Depth of the fullest of `bins` bins, nothing without measurements.
std::optional<double> VoteForDepth(const PixelSensor& sensor, int bins);

/// The prior of [VH11] Sec. 4.2: 99 % of the Gaussian between z_min and z_max.
Posterior<double> PriorOf(const PixelSensor& sensor, double a0, double b0);

/// The parametric posterior after the first `count` measurements.
Posterior<double> UpdateInTurn(const PixelSensor& sensor, Posterior<double> prior, int count);

/// The dense posterior after the first `count` measurements, from a uniform prior.
reference::DensePosterior DenseAfter(const PixelSensor& sensor, int z_bins, int pi_bins, int count);

/// The maximum of the posterior without a grid: from the mode of the dense posterior (500 x 100, as
/// in Sec. 3.1), climbed by EM. With a uniform prior it is also the maximum of the likelihood.
reference::MixtureFit ClimbFrom(const PixelSensor& sensor, const reference::DensePosterior& dense);

}  // namespace livemvs::experiments
