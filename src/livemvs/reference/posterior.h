#pragma once

#include <vector>

#include "livemvs/core/posterior.h"

/// Slow, literal, in double: what the fast code is tested against.
namespace livemvs::reference {

/// [VH11] Eq. (4) with its moments as the supplement and all public implementations write them:
/// E[Z²] − E[Z]² for the variance, e = E[π²] and f = E[π] for the Beta. Both cancel; core's Fuse()
/// does not. Made for float and double: in float it shows why not.
template <typename T>
Posterior<T> FuseTextbook(const Posterior<T>& q, T x, T tau2, T u);

/// First two moments of a posterior over (Z, pi).
struct PosteriorMoments {
  double mean_z;
  double var_z;
  double mean_pi;
  double mean_pi2;  ///< E[pi²]
};

/// The parameters of N(Z) Beta(pi) that have these moments, [VH11] Sec. 3.2.
Posterior<double> MatchMoments(const PosteriorMoments& m);

/// The posterior of [VH11] Sec. 3.1 without any approximation but the grid: a dense 2-D histogram
/// over (Z, pi), updated by Eq. (2) with the likelihood of Eq. (1).
class DensePosterior {
 public:
  /// A uniform posterior on [z_min, z_max] x [0, 1], as in the paper's Fig. 3.
  DensePosterior(double z_min, double z_max, int z_bins, int pi_bins);

  /// Sets it to the product of Eq. (3).
  void SetPrior(const Posterior<double>& q);

  /// Multiplies by pi N(x | Z, tau2) + (1 - pi) u and normalises.
  void Update(double x, double tau2, double u);

  PosteriorMoments Moments() const;

  /// The place of the maximum of the marginal over Z: the paper's estimate.
  double ModeOfZ() const;

  double Z(int i) const { return z_min_ + (i + 0.5) * z_step_; }
  double Pi(int j) const { return (j + 0.5) / pi_bins_; }
  /// Probability mass of a bin.
  double Mass(int i, int j) const { return mass_[static_cast<std::size_t>(i) * pi_bins_ + j]; }

 private:
  void Normalise();

  double z_min_;
  double z_step_;
  int z_bins_;
  int pi_bins_;
  std::vector<double> mass_;  // (z_bins, pi_bins), row-major
};

}  // namespace livemvs::reference
