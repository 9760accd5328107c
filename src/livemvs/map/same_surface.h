#pragma once

#include <Eigen/Core>
#include <cmath>

#include "livemvs/core/point.h"

namespace livemvs {

/// Whether a point has all that what is said of its surroundings needs: where it is and how surely,
/// from where it was seen, and how wide its pixel is.
inline bool IsWhole(const Point& p) {
  return p.position.allFinite() && p.normal.allFinite() && p.normal.squaredNorm() > 0.5F &&
         p.footprint > 0 && std::isfinite(p.footprint) && std::isfinite(p.sigma);
}

/// The width of a pixel of the finest level at a point [scene].
inline float FinestFootprint(const Point& p) { return std::ldexp(p.footprint, -p.level); }

/// Where a point lies from another, as the camera of the latter saw it.
struct Seen {
  Eigen::Vector3f across;  ///< The line of sight [scene].
  float deep;              ///< Along it, towards the camera [scene].
};

inline Seen SeenFrom(const Point& p, const Point& other) {
  const Eigen::Vector3f offset = other.position - p.position;
  const float deep = offset.dot(p.normal);
  return {offset - deep * p.normal, deep};
}

/// Whether two points may lie on one surface: along the line of sight no further apart than twice
/// the distance across it, which is a slope of 63 degrees, or than two standard deviations of both.
inline bool MayShareSurface(const Point& p, const Point& other, const Seen& seen) {
  constexpr float kSteepest = 2, kSigmas = 2;
  const float across2 = seen.across.squaredNorm();
  if (seen.deep * seen.deep <= kSteepest * kSteepest * across2) return true;  // mostly
  return std::abs(seen.deep) <=
         kSteepest * std::sqrt(across2) + kSigmas * std::hypot(p.sigma, other.sigma);
}

}  // namespace livemvs
