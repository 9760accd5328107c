#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// What a PLY file holds, as far as we read it.
struct PlyContents {
  PointCloud cloud;                    ///< The vertices; what the file does not say is zero.
  std::vector<Eigen::Vector3i> faces;  ///< Triangles over `cloud`; polygons are cut into fans.
  bool has_normals = false;
  bool has_colors = false;
  std::vector<std::string> comments;  ///< The text of the header's comment lines.
  std::int64_t dropped_vertices = 0;  ///< Left out, because their position was not finite.
  std::int64_t dropped_faces = 0;     ///< Left out, because they used such a vertex.
};

struct PlyReadOptions {
  /// A compressed file that unpacks to more than this is refused. [bytes]
  std::int64_t max_unpacked_bytes = std::int64_t{8} << 30;
};

/// Reads a PLY file: ascii or binary of either byte order, properties in any order and of any
/// scalar type, unknown ones passed over; compressed by gzip (.ply.gz) or not.
/// @throws Error (kBadInput) naming the file, the place and what is wrong with it.
PlyContents ReadPly(const std::filesystem::path& path, const PlyReadOptions& options = {});

/// Reads a PLY file that must hold faces.
/// @throws Error (kBadInput) as ReadPly.
TriangleMesh ReadMeshPly(const std::filesystem::path& path, const PlyReadOptions& options = {});

/// The mesh of the vertices that a PLY file holds as points.
TriangleMesh MeshOf(const PointCloud& vertices,
                    std::vector<Eigen::Vector3i> faces,
                    bool with_colors);

/// Writes a cloud as binary little-endian PLY: x y z nx ny nz red green blue sigma inlier_ratio
/// views, and frame where a point knows it. The file appears whole or not at all.
/// @param normals  What the normals mean, for the header: "towards the first camera".
/// @throws Error (kOutOfResource) where the file cannot be written.
void WritePly(const std::filesystem::path& path,
              const PointCloud& cloud,
              const std::string& normals);

/// Writes a mesh as binary little-endian PLY: x y z [red green blue], vertex_indices.
/// @throws Error (kOutOfResource) where the file cannot be written; std::invalid_argument where
/// faces name vertices that do not exist or the colours are not one per vertex.
void WritePly(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace livemvs
