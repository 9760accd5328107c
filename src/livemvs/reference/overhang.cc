#include "livemvs/reference/overhang.h"

#include <cmath>

#include "livemvs/core/lean.h"

namespace livemvs::reference {

int Supporters(const PointCloud& cloud, std::size_t point, double reach_px) {
  const Point& p = cloud[point];
  const Eigen::Vector3d at = p.position.cast<double>(), sight = p.normal.cast<double>();
  const Eigen::Vector3d away = -LeanDirection(p.normal, p.lean).cast<double>();
  const double reach = reach_px * static_cast<double>(p.footprint) / std::pow(2.0, p.level);
  int supporters = 0;
  for (const Point& q : cloud) {
    if (q.lean != kLeanNowhere) continue;
    const Eigen::Vector3d offset = q.position.cast<double>() - at;
    const double depth = std::abs(offset.dot(sight));
    const Eigen::Vector3d across = offset - offset.dot(sight) * sight;
    const double ahead = across.dot(away), sideways = (across - ahead * away).norm();
    const double sigma = std::hypot(static_cast<double>(p.sigma), static_cast<double>(q.sigma));
    const bool in_cone = ahead > 0 && ahead <= reach && sideways <= 0.6 * ahead;
    if (in_cone && depth <= 2 * across.norm() + 2 * sigma) ++supporters;
  }
  return supporters;
}

}  // namespace livemvs::reference
