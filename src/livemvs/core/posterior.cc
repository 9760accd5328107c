#include "livemvs/core/posterior.h"

#include <limits>

namespace livemvs {
namespace {

// The continued fraction of I_x(a, b), Abramowitz and Stegun 26.5.8, by the modified Lentz
// algorithm.
double BetaFraction(double x, double a, double b) {
  constexpr double kTiny = 1e-300;
  constexpr double kTolerance = 1e-14;
  const auto guard = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1;
  double d = 1 / guard(1 - (a + b) * x / (a + 1));
  double result = d;
  for (int m = 1; m < 100'000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / guard(1 + even * d);
    c = guard(1 + even / c);
    result *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / guard(1 + odd * d);
    c = guard(1 + odd / c);
    const double factor = d * c;
    result *= factor;
    if (std::abs(factor - 1) < kTolerance) break;
  }
  return result;
}

}  // namespace

double BetaCdf(double x, double a, double b) {
  if (!(x > 0)) return 0;
  if (!(x < 1)) return 1;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * BetaFraction(x, a, b) / a;
  return 1 - front * BetaFraction(1 - x, b, a) / b;
}

OutlierRule::OutlierRule(double eta, double certainty) {
  double low = 0;
  for (int i = 0; i < kEntries; ++i) {
    if (eta <= 0) {  // a ratio cannot be below 0: nothing is ever condemned
      b_max_[i] = std::numeric_limits<float>::max();
      continue;
    }
    const double a = std::max(i / static_cast<double>(kPerUnit), 1e-3);
    double high = std::max(2 * low, 1.0);
    while (BetaCdf(eta, a, high) <= certainty) high *= 2;
    for (int step = 0; step < 60; ++step) {
      const double middle = (low + high) / 2;
      (BetaCdf(eta, a, middle) <= certainty ? low : high) = middle;
    }
    b_max_[i] = static_cast<float>(high);
    // The threshold grows with a: the next search starts here.
  }
}

}  // namespace livemvs
