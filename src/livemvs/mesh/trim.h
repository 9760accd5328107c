#pragma once

#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/mesh/mesh_camera.h"
#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/sight_lines.h"

namespace livemvs {

/// What trimming took away.
struct TrimStatistics {
  std::size_t unsupported_faces = 0;  ///< Too far from every point, ...
  std::size_t sideways_faces = 0;     ///< ... or not close to one, and seen from the side at most.
  std::size_t specks = 0;             ///< Parts of the surface.
};

/// Distance of each vertex to the nearest point. [scene]
std::vector<float> DistancesToPoints(const SightLines& sights, const TriangleMesh& mesh);

/// Opens the surface where no point supports it, and removes specks. The rest stays a manifold.
/// @param h  Side of the voxels that the surface was made of. [scene]
TrimStatistics TrimMesh(const SightLines& sights,
                        const MeshCameras& cameras,
                        double h,
                        const MeshOptions& options,
                        TriangleMesh* mesh);

}  // namespace livemvs
