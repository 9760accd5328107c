#pragma once

#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/mesh/mesh_options.h"

namespace livemvs {

/// Draws the surface taut where no point holds it: each free vertex moves towards the middle of its
/// neighbours, rim and held vertices stay. Where that makes faces intersect, the vertices about
/// them go back.
/// @param free  One for each vertex.
void FairMesh(const std::vector<char>& free,
              int rounds,
              const MeshWatch& watch,
              TriangleMesh* mesh);

}  // namespace livemvs
