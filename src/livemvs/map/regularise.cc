#include "livemvs/map/regularise.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "livemvs/map/picked_points.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

// Steps of iteratively reweighted least squares: the third changes little.
constexpr int kIterations = 3;

// A neighbour supports a plane from which it lies less than this many standard deviations.
constexpr double kSupportSigmas = 1.5;

struct Neighbor {
  Eigen::Vector3d offset;  // from the point
  double sigma;
};

struct Plane {
  double distance = 0;  // from the point along the normal [scene]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  int support = 0;
};

// Weighted least squares, the weights falling with the residual like a Gaussian's.
Plane FitPlane(const std::vector<Neighbor>& neighbors) {
  Plane plane;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    double total = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Neighbor& n : neighbors) {
      const double residual = (n.offset.dot(plane.normal) - plane.distance) / n.sigma;
      const double weight = std::exp(-0.5 * residual * residual) / (n.sigma * n.sigma);
      total += weight;
      mean += weight * n.offset;
      second += weight * n.offset * n.offset.transpose();
    }
    if (!(total > 0)) return {};
    mean /= total;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(second / total - mean * mean.transpose());
    plane.normal = solver.eigenvectors().col(0);
    plane.distance = mean.dot(plane.normal);
  }
  for (const Neighbor& n : neighbors) {
    const double residual = std::abs(n.offset.dot(plane.normal) - plane.distance);
    if (residual < kSupportSigmas * n.sigma) ++plane.support;
  }
  return plane;
}

bool KnowsItsUncertainty(const Point& p) {
  return p.position.allFinite() && p.sigma > 0 && std::isfinite(p.sigma) && p.footprint > 0 &&
         std::isfinite(p.footprint);
}

// A plane through fewer points than this fits whatever they are.
constexpr int kLeastForPlane = 6;

}  // namespace

void RegularisationOptions::Check() const {
  const auto require = [](bool ok, const char* field, const char* allowed) {
    if (!ok) throw std::invalid_argument(std::string(field) + " must be " + allowed);
  };
  require(radius_px > 0 && std::isfinite(radius_px), "radius_px", "positive");
  require(neighbors >= kLeastForPlane && neighbors <= 1000, "neighbors", "6 ... 1000");
  require(min_support >= 0 && min_support <= neighbors, "min_support", "0 ... neighbors");
}

std::vector<char> Regularise(const RegularisationOptions& options, PointCloud* cloud) {
  options.Check();
  const PickedPoints picked = PickPoints(*cloud, KnowsItsUncertainty);
  const std::vector<std::size_t>& rows = picked.rows;
  const PointIndex& index = picked.index;
  std::vector<char> unsupported(cloud->size(), 0);
  ParallelForRange(0, index.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> nearest;
    std::vector<Neighbor> neighbors;
    for (std::size_t i = first; i < last; ++i) {
      Point& point = (*cloud)[rows[i]];
      const Eigen::Vector3f origin = index.points()[i];
      const float radius = options.radius_px * point.footprint;
      index.Nearest(origin, options.neighbors, &nearest);
      neighbors.clear();
      for (const PointIndex::Neighbor& n : nearest) {
        if (n.distance2 > radius * radius) break;
        neighbors.push_back({(index.points()[n.index] - origin).cast<double>(),
                             static_cast<double>((*cloud)[rows[n.index]].sigma)});
      }
      const Plane plane = FitPlane(neighbors);
      unsupported[rows[i]] = plane.support < options.min_support;
      if (plane.support < kLeastForPlane) continue;
      const double sigma = point.sigma;
      const double shift = std::clamp(plane.distance, -sigma, sigma);
      point.position += (shift * plane.normal).cast<float>();
    }
  });
  return unsupported;
}

}  // namespace livemvs
