#include "livemvs/reference/posterior.h"

#include <cmath>
#include <stdexcept>

namespace livemvs::reference {
namespace {

template <typename T>
T Normal(T x, T mean, T variance) {
  constexpr T kTwoPi = T(6.283185307179586);
  const T d = x - mean;
  return std::exp(-d * d / (T(2) * variance)) / std::sqrt(kTwoPi * variance);
}

// The Beta with E[pi] = f and E[pi²] = e.
template <typename T>
Posterior<T> WithBeta(T mean, T variance, T f, T e) {
  const T a = (e - f) / (f - e / f);
  return {mean, variance, a, a * (T(1) - f) / f};
}

}  // namespace

template <typename T>
Posterior<T> FuseTextbook(const Posterior<T>& q, T x, T tau2, T u) {
  const T a = q.a, b = q.b, n = a + b, one = T(1), two = T(2);
  const T s2 = one / (one / q.sigma2 + one / tau2);
  const T m = s2 * (q.mu / q.sigma2 + x / tau2);
  const T c1_raw = a / n * Normal(x, q.mu, q.sigma2 + tau2);
  const T c2_raw = b / n * u;
  const T c1 = c1_raw / (c1_raw + c2_raw), c2 = c2_raw / (c1_raw + c2_raw);
  const T f = c1 * (a + one) / (n + one) + c2 * a / (n + one);
  const T e = c1 * (a + one) * (a + two) / ((n + one) * (n + two)) +
              c2 * a * (a + one) / ((n + one) * (n + two));
  const T mean = c1 * m + c2 * q.mu;
  const T variance = c1 * (s2 + m * m) + c2 * (q.sigma2 + q.mu * q.mu) - mean * mean;
  return WithBeta(mean, variance, f, e);
}

template Posterior<float> FuseTextbook(const Posterior<float>&, float, float, float);
template Posterior<double> FuseTextbook(const Posterior<double>&, double, double, double);

Posterior<double> MatchMoments(const PosteriorMoments& m) {
  return WithBeta(m.mean_z, m.var_z, m.mean_pi, m.mean_pi2);
}

DensePosterior::DensePosterior(double z_min, double z_max, int z_bins, int pi_bins)
    : z_min_(z_min), z_step_((z_max - z_min) / z_bins), z_bins_(z_bins), pi_bins_(pi_bins) {
  if (!(z_min < z_max) || z_bins < 1 || pi_bins < 1) {
    throw std::invalid_argument("the dense posterior needs z_min < z_max and at least one bin");
  }
  mass_.assign(static_cast<std::size_t>(z_bins) * pi_bins, 1.0);
  Normalise();
}

void DensePosterior::SetPrior(const Posterior<double>& q) {
  std::vector<double> beta(pi_bins_);
  const double log_norm = std::lgamma(q.a + q.b) - std::lgamma(q.a) - std::lgamma(q.b);
  for (int j = 0; j < pi_bins_; ++j) {
    beta[j] = std::exp(log_norm + (q.a - 1) * std::log(Pi(j)) + (q.b - 1) * std::log1p(-Pi(j)));
  }
  for (int i = 0; i < z_bins_; ++i) {
    const double normal = Normal(Z(i), q.mu, q.sigma2);
    for (int j = 0; j < pi_bins_; ++j) {
      mass_[static_cast<std::size_t>(i) * pi_bins_ + j] = normal * beta[j];
    }
  }
  Normalise();
}

void DensePosterior::Update(double x, double tau2, double u) {
  std::vector<double> pi(pi_bins_), bad(pi_bins_);
  for (int j = 0; j < pi_bins_; ++j) {
    pi[j] = Pi(j);
    bad[j] = (1 - Pi(j)) * u;
  }
  for (int i = 0; i < z_bins_; ++i) {
    const double good = Normal(x, Z(i), tau2);
    double* row = &mass_[static_cast<std::size_t>(i) * pi_bins_];
    for (int j = 0; j < pi_bins_; ++j) row[j] *= pi[j] * good + bad[j];
  }
  Normalise();
}

PosteriorMoments DensePosterior::Moments() const {
  PosteriorMoments m{};
  for (int i = 0; i < z_bins_; ++i) {
    for (int j = 0; j < pi_bins_; ++j) {
      m.mean_z += Mass(i, j) * Z(i);
      m.mean_pi += Mass(i, j) * Pi(j);
      m.mean_pi2 += Mass(i, j) * Pi(j) * Pi(j);
    }
  }
  for (int i = 0; i < z_bins_; ++i) {
    for (int j = 0; j < pi_bins_; ++j) {
      m.var_z += Mass(i, j) * (Z(i) - m.mean_z) * (Z(i) - m.mean_z);
    }
  }
  return m;
}

double DensePosterior::ModeOfZ() const {
  int best = 0;
  double best_mass = -1;
  for (int i = 0; i < z_bins_; ++i) {
    double mass = 0;
    for (int j = 0; j < pi_bins_; ++j) mass += Mass(i, j);
    if (mass > best_mass) {
      best_mass = mass;
      best = i;
    }
  }
  return Z(best);
}

void DensePosterior::Normalise() {
  // A sum for each inlier ratio first: such sums do not wait for each other.
  std::vector<double> sums(pi_bins_, 0.0);
  for (int i = 0; i < z_bins_; ++i) {
    const double* row = &mass_[static_cast<std::size_t>(i) * pi_bins_];
    for (int j = 0; j < pi_bins_; ++j) sums[j] += row[j];
  }
  double sum = 0;
  for (const double s : sums) sum += s;
  if (!(sum > 0)) throw std::invalid_argument("the measurement is impossible on this grid");
  const double scale = 1 / sum;
  for (double& m : mass_) m *= scale;
}

}  // namespace livemvs::reference
