#pragma once

#include "livemvs/core/mesh.h"
#include "livemvs/core/point.h"
#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/sight_lines.h"
#include "livemvs/mesh/trim.h"

namespace livemvs {

/// How a mesh came about.
struct MeshStatistics {
  std::size_t points = 0;                                ///< That it was made of.
  std::size_t points_seen = 0;                           ///< Of which so many know their camera.
  std::size_t not_finite = 0, repeated = 0, lonely = 0;  ///< Points left out.
  double voxel = 0;                                      ///< Side of the finest voxels. [scene]
  int levels = 0;
  std::size_t voxels = 0;  ///< Of the finest level.
  TrimStatistics trimmed;
  std::size_t intersections = 0;  ///< Pairs of faces that intersect, at the end.
  std::size_t bad_edges = 0;      ///< Edges that are not of a manifold, at the end.
  std::size_t pinched = 0;        ///< Likewise vertices.
  std::size_t border_edges = 0;   ///< Edges with one face: the rims of what is open.
  bool simplified = true;         ///< As few faces as asked for were reached.
  double seconds_cut = 0, seconds_surface = 0, seconds_finish = 0;
};

struct BuiltMesh {
  TriangleMesh mesh;
  MeshStatistics statistics;
};

/// The surface of a cloud: minimum cut, field, triangles, trimming, fairing, decimation, with the
/// colours of the points where they have any (docs/meshing.md). Deterministic; multi-threaded.
/// @throws Error (kBadInput) where the cloud has no surface, (kOutOfResource) where the grid does
/// not fit the memory; std::invalid_argument naming an option; MeshInterrupted.
BuiltMesh BuildMesh(const PointCloud& cloud,
                    const MeshCameras& cameras,
                    const MeshOptions& options,
                    const MeshWatch& watch);

}  // namespace livemvs
