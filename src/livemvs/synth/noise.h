#pragma once

#include <Eigen/Core>

namespace livemvs::synth {

/// Gradient noise on the integer lattice: continuous, mean 0, within [-1, 1], standard deviation
/// about 0.27, features about one unit wide.
float GradientNoise(const Eigen::Vector3f& p);

/// Sum of octaves of gradient noise whose features shrink from `wavelength` downwards, `gain` times
/// the amplitude at each halving; mean 0, standard deviation about 0.27 * 1.6. Octaves finer than a
/// pixel can show fade out, so that the texture does not alias.
/// @param footprint  Width of a pixel on the surface, in the unit of `p`.
float FractalNoise(const Eigen::Vector3f& p, float wavelength, float gain, float footprint);

/// Cells around one random point per unit cube.
struct Cell {
  float edge = 0;        ///< Distance to the nearest border between cells, >= 0.
  std::uint32_t id = 0;  ///< Random word of the cell.
};
Cell NearestCell(const Eigen::Vector3f& p);

/// 0 below `low`, 1 above `high`, smooth between.
inline float SmoothStep(float low, float high, float x) {
  const float t = x <= low ? 0.f : x >= high ? 1.f : (x - low) / (high - low);
  return t * t * (3.f - 2.f * t);
}

/// A uniform number in [0, 1) of a cell of the integer lattice.
float LatticeUniform(int x, int y, int z);

}  // namespace livemvs::synth
