#include "livemvs/reference/rim.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace livemvs::reference {

double WidestGap(const PointCloud& cloud, std::size_t point, double radius_px) {
  constexpr double kTurn = 2 * std::numbers::pi;
  struct Other {
    double distance;
    Eigen::Vector3d across;
  };
  const Point& p = cloud[point];
  const Eigen::Vector3d sight = p.normal.cast<double>();
  std::vector<Other> others;
  for (const Point& q : cloud) {
    const Eigen::Vector3d offset = q.position.cast<double>() - p.position.cast<double>();
    const Eigen::Vector3d across = offset - offset.dot(sight) * sight;
    const double sigma = std::hypot(static_cast<double>(p.sigma), static_cast<double>(q.sigma));
    const bool agrees = std::abs(offset.dot(sight)) <= 2 * across.norm() + 2 * sigma;
    if (&q != &p && agrees) others.push_back({offset.norm(), across});
  }
  std::stable_sort(others.begin(), others.end(), [](const Other& a, const Other& b) {
    return a.distance < b.distance;
  });
  const double radius = radius_px * static_cast<double>(p.footprint) / std::pow(2.0, p.level);
  if (others.size() < 8 || others[7].distance > 4 * radius) return 0;
  while (others.size() > 8 && others.back().distance > radius) others.pop_back();

  // From each direction, how far one turns to the left until the next.
  double widest = 0;
  for (const Other& a : others) {
    double next = kTurn;
    for (const Other& b : others) {
      double turn = std::atan2(a.across.cross(b.across).dot(sight), a.across.dot(b.across));
      if (turn < 0) turn += kTurn;
      if (&a != &b && turn < next) next = turn;
    }
    widest = std::max(widest, next);
  }
  return widest;
}

}  // namespace livemvs::reference
