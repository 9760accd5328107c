#pragma once

#include <cstdint>

namespace livemvs::synth {

/// A well-mixed 64-bit word from any other (the finaliser of SplitMix64). The base of everything
/// random in the module, so that a number depends on what it is for and not on the order of calls.
constexpr std::uint64_t Mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// A small generator with the same numbers on every platform, which <random>'s distributions lack.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(Mix(seed)) {}

  /// Uniform in [0, 1).
  double Uniform() {
    state_ = Mix(state_);
    return static_cast<double>(state_ >> 11) * 0x1.0p-53;
  }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }

 private:
  std::uint64_t state_;
};

}  // namespace livemvs::synth
