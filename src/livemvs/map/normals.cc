#include "livemvs/map/normals.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "livemvs/map/point_index.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr int kMinNeighbors = 5;
constexpr float kNearFactor = 10;
constexpr float kLonelyFactor = 1.5f;
/// Neighbours spread less than this ratio of their length across it form a line, not a plane.
constexpr double kMinWidth2 = 1e-4;

struct FinitePoints {
  std::vector<std::uint32_t> rows;  ///< Where the points stand in the cloud.
  std::vector<Eigen::Vector3f> positions;
};

/// Spreads the low 21 bits of v three apart.
std::uint64_t SpreadBits(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffffull;
  v = (v | v << 16) & 0x001f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

/// The finite points, along a Morton curve: neighbours are then near in memory too, which makes
/// searches several times faster.
FinitePoints SelectFinite(const PointCloud& cloud) {
  Eigen::Vector3d lo = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d hi = -lo;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud[i].position.allFinite()) continue;
    keys.emplace_back(0, static_cast<std::uint32_t>(i));
    lo = lo.cwiseMin(cloud[i].position.cast<double>());
    hi = hi.cwiseMax(cloud[i].position.cast<double>());
  }
  const double extent = keys.empty() ? 0 : (hi - lo).maxCoeff();
  const double scale = extent > 0 ? ((1 << 21) - 1) / extent : 0;
  for (auto& [key, row] : keys) {
    const Eigen::Vector3d cell = (cloud[row].position.cast<double>() - lo) * scale;
    key = SpreadBits(static_cast<std::uint64_t>(cell.x())) |
          SpreadBits(static_cast<std::uint64_t>(cell.y())) << 1 |
          SpreadBits(static_cast<std::uint64_t>(cell.z())) << 2;
  }
  tbb::parallel_sort(keys.begin(), keys.end());
  FinitePoints finite;
  finite.rows.reserve(keys.size());
  finite.positions.reserve(keys.size());
  for (const auto& [key, row] : keys) {
    finite.rows.push_back(row);
    finite.positions.push_back(cloud[row].position);
  }
  return finite;
}

/// Squared distance of every `step`-th point to its k-th nearest other point.
std::vector<float> KthDistance2(const PointIndex& index, int k, std::size_t step) {
  std::vector<float> distance2((index.size() + step - 1) / step,
                               std::numeric_limits<float>::infinity());
  ParallelForRange(0, distance2.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = first; i != last; ++i) {
      index.Nearest(index.points()[i * step], k + 1, &neighbors);
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

  constexpr std::size_t kMedianOf = 20000;
  const float median2 = Median(KthDistance2(index, count - 1, index.size() / kMedianOf + 1));
  const float max_distance2 = kNearFactor * kNearFactor * median2;
  ParallelForRange(0, index.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = first; i != last; ++i) {
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
  std::vector<float> spacing(cloud.size(), 0.0f);
  std::vector<float> own(index.size(), std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> nearest(index.size() * static_cast<std::size_t>(k));
  ParallelForRange(0, index.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = first; i != last; ++i) {
      index.Nearest(index.points()[i], k + 1, &neighbors);
      for (std::size_t j = 0; j < static_cast<std::size_t>(k); ++j) {
        const bool known = j + 1 < neighbors.size();
        nearest[i * static_cast<std::size_t>(k) + j] =
            known ? neighbors[j + 1].index : static_cast<std::uint32_t>(i);
      }
      if (neighbors.size() > static_cast<std::size_t>(k)) {
        own[i] = std::sqrt(neighbors.back().distance2);
      }
    }
  });
  // A lonely point beside a surface takes the spacing of the surface.
  ParallelForRange(0, index.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<float> others(static_cast<std::size_t>(k));
    for (std::size_t i = first; i != last; ++i) {
      for (std::size_t j = 0; j < others.size(); ++j) {
        others[j] = own[nearest[i * others.size() + j]];
      }
      const auto quartile = others.begin() + static_cast<std::ptrdiff_t>(others.size() / 4);
      std::nth_element(others.begin(), quartile, others.end());
      spacing[finite.rows[i]] = std::min(own[i], kLonelyFactor * *quartile);
    }
  });
  return spacing;
}

}  // namespace livemvs
