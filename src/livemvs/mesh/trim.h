#pragma once

#include "livemvs/core/mesh.h"
#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/sight_lines.h"

namespace livemvs {

/// What trimming took away.
struct TrimStatistics {
  std::size_t unsupported_faces = 0;  ///< Far from every point.
  std::size_t specks = 0;             ///< Parts of the surface.
};

/// Opens the surface where no point supports it, and removes specks. The rest stays a manifold.
/// @param h  Side of the voxels that the surface was made of. [scene]
TrimStatistics TrimMesh(const SightLines& sights,
                        double h,
                        const MeshOptions& options,
                        TriangleMesh* mesh);

}  // namespace livemvs
