#pragma once

#include <cmath>

#include "livemvs/core/platform.h"

namespace livemvs {

/// The posterior of a seed, [VH11] Eq. (3): N(Z | mu, sigma2) Beta(pi | a, b). Z is a coordinate
/// along the ray, 0 and 1 at the ends of the seed's interval, so that float32 suffices
/// (docs/algorithm.md).
template <typename T>
struct Posterior {
  T mu;
  T sigma2;
  T a;
  T b;
};

template <typename T>
LIVEMVS_HD inline T InlierRatio(const Posterior<T>& q) {
  return q.a / (q.a + q.b);
}

/// exp(x) for x in [0, 87], the same on every instruction set and device; relative error below
/// 3e-7.
template <typename T>
LIVEMVS_HD inline T Exp(T x) {
  const T log2_e(1.44269504F);
  // ln 2 in two parts, the first exact in the product with a small integer (Cody and Waite).
  const T ln2_high(0.693359375F), ln2_low(-2.12194440e-4F);
  const T n = Floor(x * log2_e + T(0.5F));
  const T r = (x - n * ln2_high) - n * ln2_low;
  // Taylor series on |r| <= ln 2 / 2; the remainder is below 1e-8.
  T p(1.0F / 5040);
  p = p * r + T(1.0F / 720);
  p = p * r + T(1.0F / 120);
  p = p * r + T(1.0F / 24);
  p = p * r + T(1.0F / 6);
  p = p * r + T(0.5F);
  p = p * r + T(1.0F);
  p = p * r + T(1.0F);
  return Pow2(n) * p;
}

LIVEMVS_HD inline double Exp(double x) { return std::exp(x); }

/// What Fuse() returns.
template <typename T>
struct Fused {
  Posterior<T> posterior;
  T inlier_weight;  ///< w1, the probability that the measurement was a good one.
};

/// Fuses one measurement into the posterior: [VH11] Eq. (4), moments matched.
///
/// The product is the mixture w1 N(Z | m, s²) Beta(a + 1, b) + w2 N(Z | mu, sigma2) Beta(a, b + 1);
/// this is the form of its first two moments in which all terms are positive and nothing cancels.
/// With K = σ²/(σ² + τ²), d = x − μ and r = w2/w1:
///     r  = (b/a) sqrt(2π(σ² + τ²)) u exp(d²/(2(σ² + τ²)))
///     μ' = μ + w1 K d,   σ'² = w2 σ² + w1 K τ² + (w1 K d)(w2 K d)
///     A  = ab + w1 b + w2 a,   ρ = A/(A + w1 w2 (a + b + 2)),   a' = ρ(a + w1),   b' = ρ(b + w2).
///
/// @param x     Measured coordinate.
/// @param tau2  Variance of the measurement, > 0.
/// @param u     Density of an outlier at x, > 0.
template <typename T>
LIVEMVS_HD inline Fused<T> Fuse(const Posterior<T>& q, T x, T tau2, T u) {
  const T two_pi = T(6.283185307179586);
  const T v = q.sigma2 + tau2;
  const T gain = q.sigma2 / v;
  const T d = x - q.mu;
  // Exponents are bounded, not only r, so that r times anything stays finite.
  const T exponent = d * d / (T(2) * v);
  const T bounded = Select(exponent < T(60), exponent, T(60));
  T r = (q.b / q.a) * Sqrt(two_pi * v) * u * Exp(bounded);
  r = Select(r < T(1e30), r, T(1e30));
  const T w1 = T(1) / (T(1) + r);
  const T w2 = r * w1;
  const T shift = gain * d;
  Posterior<T> p;
  p.mu = q.mu + w1 * shift;
  p.sigma2 = w2 * q.sigma2 + w1 * gain * tau2 + (w1 * shift) * (w2 * shift);
  const T strength = q.a * q.b + w1 * q.b + w2 * q.a;
  const T rho = strength / (strength + w1 * w2 * (q.a + q.b + T(2)));
  p.a = rho * (q.a + w1);
  p.b = rho * (q.b + w2);
  return {p, w1};
}

/// A frame in which the seed was in view and found no match: [VH11] Sec. 4.2, b := b + 1.
template <typename T>
LIVEMVS_HD inline Posterior<T> Miss(Posterior<T> q) {
  q.b += T(1);
  return q;
}

/// P(pi < x) under Beta(a, b), the regularised incomplete beta function I_x(a, b). In double, by
/// Lentz's continued fraction; relative error below 1e-10 for a, b in (0, 1e5).
double BetaCdf(double x, double a, double b);

/// The failures that condemn a seed, precomputed: the least b for which P(pi < eta) > certainty, as
/// a function of a. [VH11] Sec. 4.3, criterion 1, without an incomplete beta function in the loop.
class OutlierRule {
 public:
  OutlierRule(double eta, double certainty);

  /// True where the inlier ratio is below eta with the given certainty.
  template <typename T>
  LIVEMVS_HD inline MaskOf<T> operator()(T a, T b) const {
    const T position = a * T(kPerUnit);
    const MaskOf<T> inside = position < T(static_cast<float>(kEntries - 1));
    const T at = Select(inside, position, T(0));
    const T i = Floor(at);
    const T from = Lookup(b_max_, i), to = Lookup(b_max_ + 1, i);
    return inside & (b > from + (at - i) * (to - from));
  }

 private:
  static constexpr int kEntries = 512;
  static constexpr float kPerUnit = 8;  // entries per unit of a: a up to 64
  float b_max_[kEntries];
};

}  // namespace livemvs
