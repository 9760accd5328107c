#include "livemvs/map/normals.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "livemvs/map/point_index.h"

namespace livemvs {
namespace {

constexpr int kMinNeighbors = 5;
constexpr float kNearFactor = 10;
/// Neighbours spread less than this ratio of their length across it form a line, not a plane.
constexpr double kMinWidth2 = 1e-4;

struct FinitePoints {
  std::vector<std::uint32_t> rows;  ///< Where the points stand in the cloud.
  std::vector<Eigen::Vector3f> positions;
};

FinitePoints SelectFinite(const PointCloud& cloud) {
  FinitePoints finite;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud[i].position.allFinite()) continue;
    finite.rows.push_back(static_cast<std::uint32_t>(i));
    finite.positions.push_back(cloud[i].position);
  }
  return finite;
}

template <typename F>
void ParallelFor(std::size_t count, const F& f) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) { f(range); });
}

/// Squared distance of each point to its k-th nearest other point.
std::vector<float> KthDistance2(const PointIndex& index, int k) {
  std::vector<float> distance2(index.size(), std::numeric_limits<float>::infinity());
  ParallelFor(index.size(), [&](const tbb::blocked_range<std::size_t>& range) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      index.Nearest(index.points()[i], k + 1, &neighbors);
      if (neighbors.size() == static_cast<std::size_t>(k) + 1) {
        distance2[i] = neighbors.back().distance2;
      }
    }
  });
  return distance2;
}

float Median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The direction of least spread of the neighbours, or nothing where they span no plane.
std::optional<Eigen::Vector3f> PlaneNormal(const std::vector<Eigen::Vector3f>& points,
                                           const std::vector<PointIndex::Neighbor>& neighbors,
                                           float max_distance2) {
  // Relative to the nearest neighbour, so that far from the origin nothing cancels.
  const Eigen::Vector3f origin = points[neighbors[0].index];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d sum_squares = Eigen::Matrix3d::Zero();
  int count = 0;
  for (const PointIndex::Neighbor& n : neighbors) {
    if (n.distance2 > max_distance2) break;
    const Eigen::Vector3d d = (points[n.index] - origin).cast<double>();
    sum += d;
    sum_squares += d * d.transpose();
    ++count;
  }
  if (count < kMinNeighbors) return std::nullopt;
  const Eigen::Matrix3d covariance = sum_squares - sum * sum.transpose() / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d& spread = solver.eigenvalues();  // increasing
  if (!(spread[2] > 0) || spread[1] < kMinWidth2 * spread[2]) return std::nullopt;
  return solver.eigenvectors().col(0).cast<float>().normalized();
}

}  // namespace

void EstimateNormals(PointCloud& cloud, int k) {
  if (k < kMinNeighbors) {
    throw std::invalid_argument("EstimateNormals: k = " + std::to_string(k) + " is less than " +
                                std::to_string(kMinNeighbors));
  }
  FinitePoints finite = SelectFinite(cloud);
  if (finite.rows.size() < kMinNeighbors) return;
  const PointIndex index(std::move(finite.positions));
  const int count =
      std::min<int>(k, static_cast<int>(std::min<std::size_t>(index.size(), 1 << 20)));

  const float median2 = Median(KthDistance2(index, count - 1));
  const float max_distance2 = kNearFactor * kNearFactor * median2;
  ParallelFor(index.size(), [&](const tbb::blocked_range<std::size_t>& range) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      index.Nearest(index.points()[i], count, &neighbors);
      const auto normal = PlaneNormal(index.points(), neighbors, max_distance2);
      if (!normal) continue;
      Eigen::Vector3f& current = cloud[finite.rows[i]].normal;
      current = normal->dot(current) < 0 ? -*normal : *normal;
    }
  });
}

std::vector<float> PointSpacing(const PointCloud& cloud, int k) {
  if (k < 1) throw std::invalid_argument("PointSpacing: k = " + std::to_string(k) + " is not > 0");
  FinitePoints finite = SelectFinite(cloud);
  const PointIndex index(std::move(finite.positions));
  const std::vector<float> distance2 = KthDistance2(index, k);
  std::vector<float> spacing(cloud.size(), 0.0f);
  for (std::size_t i = 0; i < finite.rows.size(); ++i) {
    spacing[finite.rows[i]] = std::sqrt(distance2[i]);
  }
  return spacing;
}

}  // namespace livemvs
