#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/core/point.h"
#include "livemvs/io/ply.h"

namespace livemvs {

/// What is handed to other programs: a mesh where `faces` is not empty, else a cloud. [scene]
struct ExchangeModel {
  PointCloud vertices;  ///< The points, or the mesh's vertices; what is not known is zero.
  std::vector<Eigen::Vector3i> faces;  ///< Counter-clockwise from outside.
  bool has_normals = false;
  bool has_colors = false;

  bool IsMesh() const { return !faces.empty(); }

  /// @throws std::invalid_argument where there is no vertex, a position is not finite, or a face
  /// names a vertex that does not exist.
  void Check() const;
};

/// The contents of a PLY file; a mesh without normals gets those of its faces.
/// @param place  Names the file in messages.
/// @throws Error (kBadInput) where there is nothing in it.
ExchangeModel MakeExchangeModel(PlyContents contents, const std::string& place);

/// A mesh, with the normals of its faces.
ExchangeModel MakeExchangeModel(const TriangleMesh& mesh);

/// Keeps of a cloud the points that at least `min_views` frames agreed on, and of these at most
/// `max_points`, evenly over the order in which they were found. 0: no limit.
/// @throws std::invalid_argument for a mesh.
void ThinCloud(std::size_t max_points, int min_views, ExchangeModel* model);

/// The normal as other programs want it: of unit length, and (0, 0, 1) where it is not known.
Eigen::Vector3f UnitNormal(const Point& point);

/// Middle of the box around the vertices, and the length of its longest side.
struct Extent {
  Eigen::Vector3d min, max;
  Eigen::Vector3d Center() const { return 0.5 * (min + max); }
  double LongestSide() const { return (max - min).maxCoeff(); }
};
Extent ExtentOf(const ExchangeModel& model);

}  // namespace livemvs
