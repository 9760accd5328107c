#include "livemvs/map/point_index.h"

#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace livemvs {
namespace {

/// The points as nanoflann reads them.
struct PointsAdaptor {
  std::vector<Eigen::Vector3f> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename BoundingBox>
  bool kdtree_get_bbox(BoundingBox&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointsAdaptor>,
                                                 PointsAdaptor,
                                                 3,
                                                 std::uint32_t>;
constexpr std::size_t kLeafSize = 32;

/// What nanoflann calls for the points that it finds.
struct VisitorSet {
  using DistanceType = float;
  using IndexType = std::uint32_t;

  float radius2;
  bool (*visit)(void* visitor, const PointIndex::Neighbor&);
  void* visitor;

  // NOLINTBEGIN(readability-identifier-naming)
  float worstDist() const { return radius2; }
  bool addPoint(float distance2, std::uint32_t index) { return visit(visitor, {index, distance2}); }
  static constexpr bool full() { return true; }
  // NOLINTEND(readability-identifier-naming)
};

}  // namespace

struct PointIndex::Impl {
  explicit Impl(std::vector<Eigen::Vector3f> points)
      : adaptor{std::move(points)},
        tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  PointsAdaptor adaptor;
  Tree tree;
};

PointIndex::PointIndex(std::vector<Eigen::Vector3f> points) {
  if (points.size() > std::numeric_limits<std::uint32_t>::max() - 1) {
    throw std::invalid_argument("PointIndex: too many points: " + std::to_string(points.size()));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw std::invalid_argument("PointIndex: point " + std::to_string(i) + " is not finite");
    }
  }
  impl_ = std::make_unique<Impl>(std::move(points));
}

PointIndex::~PointIndex() = default;
PointIndex::PointIndex(PointIndex&&) noexcept = default;
PointIndex& PointIndex::operator=(PointIndex&&) noexcept = default;

std::size_t PointIndex::size() const { return impl_->adaptor.points.size(); }

const std::vector<Eigen::Vector3f>& PointIndex::points() const { return impl_->adaptor.points; }

void PointIndex::Nearest(const Eigen::Vector3f& query,
                         int k,
                         std::vector<Neighbor>* neighbors) const {
  neighbors->clear();
  if (size() == 0 || k <= 0) return;
  // nanoflann wants two plain arrays; the sets asked for are small.
  constexpr int kOnStack = 64;
  std::uint32_t stack_indices[kOnStack];
  float stack_distances[kOnStack];
  std::vector<std::uint32_t> heap_indices;
  std::vector<float> heap_distances;
  std::uint32_t* indices = stack_indices;
  float* distances = stack_distances;
  if (k > kOnStack) {
    heap_indices.resize(static_cast<std::size_t>(k));
    heap_distances.resize(static_cast<std::size_t>(k));
    indices = heap_indices.data();
    distances = heap_distances.data();
  }
  const std::size_t found =
      impl_->tree.knnSearch(query.data(), static_cast<std::size_t>(k), indices, distances);
  neighbors->reserve(found);
  for (std::size_t i = 0; i < found; ++i) neighbors->push_back({indices[i], distances[i]});
}

void PointIndex::VisitNear(const Eigen::Vector3f& query,
                           float radius,
                           bool (*visit)(void* visitor, const Neighbor&),
                           void* visitor) const {
  if (size() == 0) return;
  VisitorSet found{radius * radius, visit, visitor};
  impl_->tree.findNeighbors(found, query.data(), {});
}

float PointIndex::NearestDistance(const Eigen::Vector3f& query) const {
  if (size() == 0) return std::numeric_limits<float>::infinity();
  std::uint32_t index = 0;
  float distance2 = 0;
  impl_->tree.knnSearch(query.data(), 1, &index, &distance2);
  return std::sqrt(distance2);
}

}  // namespace livemvs
