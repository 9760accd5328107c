#pragma once

/// Marks per-seed mathematics that is compiled both for the host and, by nvcc, for the device. On
/// the host it is always inlined, so that each instruction set's kernel has its own copy and the
/// linker cannot give one set's code to another.
#if defined(__CUDACC__)
#define LIVEMVS_HD __host__ __device__
#else
#define LIVEMVS_HD __attribute__((always_inline))
#endif

namespace livemvs {

/// v, but at least `low` and at most `high`; NaN becomes `low`.
template <typename T>
LIVEMVS_HD inline T Clamp(T v, T low, T high) {
  const T at_least = v > low ? v : low;
  return at_least < high ? at_least : high;
}

}  // namespace livemvs
