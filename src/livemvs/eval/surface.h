#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// A triangle mesh that answers questions of distance and sight. Queries are const and may run in
/// parallel. Triangles without area count with their edges.
class MeshSurface {
 public:
  /// Where a ray first meets the surface.
  struct Hit {
    float distance;               ///< In lengths of the ray's direction.
    std::uint32_t triangle;       ///< Index into the mesh's faces.
    Eigen::Vector3f barycentric;  ///< Weights of the triangle's corners.
  };

  /// The mesh is copied.
  /// @throws std::invalid_argument where it is empty, a coordinate is not finite, or a triangle
  /// names a vertex that does not exist.
  explicit MeshSurface(const TriangleMesh& mesh);
  ~MeshSurface();
  MeshSurface(MeshSurface&&) noexcept;

  /// Distance to the closest point of the surface [scene].
  double Distance(const Eigen::Vector3d& point) const;

  /// The first hit of origin + t direction, t > 0, from either side.
  std::optional<Hit> FirstHit(const Eigen::Vector3f& origin,
                              const Eigen::Vector3f& direction) const;

  /// Whether the surface meets origin + t direction for a t in [0, t_max].
  bool IsBlocked(const Eigen::Vector3f& origin,
                 const Eigen::Vector3f& direction,
                 float t_max) const;

  /// Points spread uniformly over the area of the surface, or of its part in the box. The same seed
  /// gives the same points. Fewer than `count`, possibly none, where hardly any of the surface near
  /// the box is in it.
  std::vector<Eigen::Vector3f> Sample(std::size_t count,
                                      std::uint64_t seed,
                                      const std::optional<Box>& box) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Distance from a point to a triangle [scene]; exact up to rounding for triangles of any shape.
double PointTriangleDistance(const Eigen::Vector3d& point,
                             const Eigen::Vector3d& a,
                             const Eigen::Vector3d& b,
                             const Eigen::Vector3d& c);

}  // namespace livemvs
