#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace livemvs {

/// Points that a thread takes at a time where each asks for its nearest.
inline constexpr std::size_t kPointsAtATime = 512;

/// Finds the nearest of a fixed set of points. Queries are const and may run in parallel; the same
/// points give the same answers, ties included.
class PointIndex {
 public:
  struct Neighbor {
    std::uint32_t index;  ///< Into the points given to the constructor.
    float distance2;      ///< Squared distance [scene^2].
  };

  /// @param points  At most 2^32 - 1, all finite.
  /// @throws std::invalid_argument where a coordinate is not finite.
  explicit PointIndex(std::vector<Eigen::Vector3f> points);
  ~PointIndex();
  PointIndex(PointIndex&&) noexcept;
  PointIndex& operator=(PointIndex&&) noexcept;

  std::size_t size() const;
  const std::vector<Eigen::Vector3f>& points() const;

  /// The k points nearest to `query`, nearest first; fewer where the set is smaller. A point of the
  /// set finds itself first. `neighbors` is resized; keep it between calls to save allocations.
  void Nearest(const Eigen::Vector3f& query, int k, std::vector<Neighbor>* neighbors) const;

  /// Calls `visit(neighbor)` for the points nearer to `query` than `radius` [scene], in no order
  /// that means anything, until it returns false.
  template <typename Visitor>
  void VisitNear(const Eigen::Vector3f& query, float radius, Visitor visit) const {
    VisitNear(
        query,
        radius,
        [](void* visitor, const Neighbor& n) { return (*static_cast<Visitor*>(visitor))(n); },
        &visit);
  }

  /// Distance to the nearest point [scene]; infinite where the set is empty.
  float NearestDistance(const Eigen::Vector3f& query) const;

 private:
  struct Impl;
  void VisitNear(const Eigen::Vector3f& query,
                 float radius,
                 bool (*visit)(void* visitor, const Neighbor&),
                 void* visitor) const;

  std::unique_ptr<Impl> impl_;
};

}  // namespace livemvs
