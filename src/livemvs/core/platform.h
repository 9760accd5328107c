#pragma once

#include <cmath>
#include <utility>

/// Marks per-seed mathematics that is compiled both for the host and, by nvcc, for the device. On
/// the host it is always inlined, so that each instruction set's kernel has its own copy and the
/// linker cannot give one set's code to another.
#if defined(__CUDACC__)
#define LIVEMVS_HD __host__ __device__
#else
#define LIVEMVS_HD __attribute__((always_inline))
#endif

/// Marks what runs on the device as well, and on the host is compiled as any other function.
#if defined(__CUDACC__)
#define LIVEMVS_DEVICE __host__ __device__
#else
#define LIVEMVS_DEVICE
#endif

/// Where code is compiled for a device, or for one that tests/emulated_cuda takes the place of.
#if defined(__CUDA_ARCH__) || defined(LIVEMVS_EMULATED_CUDA)
#define LIVEMVS_ON_DEVICE
#endif

namespace livemvs {

// Per-seed mathematics is written once, for a number type T that is float, double, or a vector with
// one lane per seed. So it has no branches on numbers: comparisons give a MaskOf<T>, and Select()
// chooses. Vectors bring their own overloads of the functions below.

/// What a comparison of Ts gives: bool, or a mask with one entry per lane.
template <typename T>
using MaskOf = decltype(std::declval<T>() < std::declval<T>());

/// a where the condition holds, else b.
template <typename T>
LIVEMVS_HD inline T Select(bool condition, T a, T b) {
  return condition ? a : b;
}

LIVEMVS_HD inline float Sqrt(float v) { return std::sqrt(v); }
LIVEMVS_HD inline double Sqrt(double v) { return std::sqrt(v); }
LIVEMVS_HD inline float Abs(float v) { return std::abs(v); }
LIVEMVS_HD inline double Abs(double v) { return std::abs(v); }
LIVEMVS_HD inline float Floor(float v) { return std::floor(v); }
LIVEMVS_HD inline double Floor(double v) { return std::floor(v); }
LIVEMVS_HD inline float Ceil(float v) { return std::ceil(v); }
LIVEMVS_HD inline double Ceil(double v) { return std::ceil(v); }
LIVEMVS_HD inline float Atan(float v) { return std::atan(v); }
LIVEMVS_HD inline double Atan(double v) { return std::atan(v); }

/// 2^n of a whole n in [-126, 127].
LIVEMVS_HD inline float Pow2(float n) {
  union {
    int bits;
    float value;
  } power;
  power.bits = (static_cast<int>(n) + 127) << 23;
  return power.value;
}

/// Entry `index` of a table, a whole number.
LIVEMVS_HD inline float Lookup(const float* table, float index) {
  return table[static_cast<int>(index)];
}

/// v, but at least `low` and at most `high`; NaN becomes `low`.
template <typename T>
LIVEMVS_HD inline T Clamp(T v, T low, T high) {
  const T at_least = Select(v > low, v, low);
  return Select(at_least < high, at_least, high);
}

}  // namespace livemvs
