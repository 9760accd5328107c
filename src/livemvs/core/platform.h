#pragma once

/// Marks per-seed mathematics that is compiled both for the host and, by nvcc, for the device.
#if defined(__CUDACC__)
#define LIVEMVS_HD __host__ __device__
#else
#define LIVEMVS_HD
#endif
