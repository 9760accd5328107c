#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "csv.h"
#include "experiments.h"
#include "livemvs/reference/posterior.h"

namespace livemvs::experiments {
namespace {

// Depths as a hand-held camera sees an object: from Z_min to 1.6 Z_min, in a unit of Z_min.
constexpr double kNear = 1, kRange = 0.6;

struct State {
  Posterior<double> q;
  double x, tau2, u;
};

// A state whose standard deviation is `sigma`, and a measurement that fits it.
State Draw(double sigma, std::mt19937_64* random) {
  const auto uniform = [random](double low, double high) {
    return low + (high - low) * static_cast<double>((*random)() >> 11) * 0x1.0p-53;
  };
  const auto log_uniform = [&](double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  };
  State s{};
  s.q = {kNear + kRange * uniform(0, 1), sigma * sigma, log_uniform(2, 300), log_uniform(2, 300)};
  const double tau = sigma * log_uniform(1, 10);
  s.tau2 = tau * tau;
  s.x = s.q.mu + uniform(-2, 2) * std::sqrt(s.q.sigma2 + s.tau2);
  s.u = 1 / kRange;
  return s;
}

Posterior<float> ToFloat(const Posterior<double>& q) {
  return {static_cast<float>(q.mu),
          static_cast<float>(q.sigma2),
          static_cast<float>(q.a),
          static_cast<float>(q.b)};
}

// One update of all in float: textbook or closed form.
Posterior<float> UpdateInFloat(bool textbook, const State& s) {
  const auto x = static_cast<float>(s.x), tau2 = static_cast<float>(s.tau2);
  const auto u = static_cast<float>(s.u);
  return textbook ? reference::FuseTextbook(ToFloat(s.q), x, tau2, u)
                  : Fuse(ToFloat(s.q), x, tau2, u).posterior;
}

// Share of single updates that end without a positive variance, over the width of the posterior.
void SingleUpdates(const Settings& settings) {
  const int states = settings.quick ? 500 : 20'000;
  Csv csv(settings.tables / "float_updates.csv",
          "sigma [share of range],textbook not positive,closed form not positive,"
          "textbook error [share of variance],closed form error");
  std::mt19937_64 random(1);
  for (int i = 0; i <= 32; ++i) {
    const double sigma = std::pow(10, -1 - i / 8.0);  // 0.1 to 1e-5 of the range
    double not_positive[2] = {};
    std::vector<double> error[2];
    for (int n = 0; n < states; ++n) {
      const State s = Draw(sigma * kRange, &random);
      const double exact = Fuse(s.q, s.x, s.tau2, s.u).posterior.sigma2;
      for (const bool textbook : {true, false}) {
        const Posterior<float> q = UpdateInFloat(textbook, s);
        not_positive[textbook ? 0 : 1] += q.sigma2 > 0 ? 0 : 1.0 / states;
        error[textbook ? 0 : 1].push_back(std::abs(q.sigma2 / exact - 1));
      }
    }
    const auto median = [](std::vector<double>& v) {
      std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
      return v[v.size() / 2];
    };
    csv.Row(sigma, not_positive[0], not_positive[1], median(error[0]), median(error[1]));
  }
}

// How a seed's 300 measurements end in one of the forms.
struct Ends {
  double converged = 0;     // share of seeds whose variance fell below the threshold
  double not_positive = 0;  // share of these with a variance of 0 or less
};

template <typename T>
Ends Follow(bool textbook, double epsilon, int seeds) {
  constexpr int kFrames = 300;
  constexpr double kTau = kRange / 300;  // a pixel, where the ray is 300 px long
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  int converged = 0, not_positive = 0;
  for (int n = 0; n < seeds; ++n) {
    const double depth = kNear + kRange * (0.1 + 0.8 * uniform(random));
    const double sigma = kRange / 2 / 2.5758;
    Posterior<T> q = {T(kNear + kRange / 2), T(sigma * sigma), T(10), T(10)};
    bool done = false;
    for (int i = 0; i < kFrames && !done; ++i) {
      const bool good = uniform(random) < 0.8;
      const double x =
          good ? depth + 0.3 * kTau * normal(random) : kNear + kRange * uniform(random);
      const T tau2 = T(kTau * kTau), u = T(1 / kRange);
      q = textbook ? reference::FuseTextbook(q, T(x), tau2, u) : Fuse(q, T(x), tau2, u).posterior;
      done = q.sigma2 < T(epsilon * epsilon);
    }
    converged += done ? 1 : 0;
    not_positive += done && !(q.sigma2 > 0) ? 1 : 0;
  }
  return {converged / static_cast<double>(seeds),
          converged > 0 ? not_positive / static_cast<double>(converged) : 0};
}

}  // namespace

void FloatUpdates(const Settings& settings) {
  SingleUpdates(settings);
  const int seeds = settings.quick ? 100 : 5000;
  Csv csv(settings.tables / "float_seeds.csv",
          "form,threshold [share of range],converged within 300 frames,"
          "of these with variance <= 0");
  for (const double share : {1.0 / 500, 1.0 / 10'000}) {
    const auto row = [&](const char* name, const Ends& ends) {
      csv.Row(name, share, ends.converged, ends.not_positive);
    };
    row("textbook float", Follow<float>(true, share * kRange, seeds));
    row("closed form float", Follow<float>(false, share * kRange, seeds));
    row("closed form double", Follow<double>(false, share * kRange, seeds));
  }
}

}  // namespace livemvs::experiments
