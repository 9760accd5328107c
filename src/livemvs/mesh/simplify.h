#pragma once

#include <cstddef>

#include "livemvs/core/mesh.h"
#include "livemvs/mesh/mesh_options.h"

namespace livemvs {

/// Collapses edges until at most `faces` are left, those first that change the surface least
/// (meshoptimizer: quadrics). What is left uses some of the vertices as they are, and is a manifold
/// that does not intersect itself if the mesh was: where it would not be, the surface stays as fine
/// as it is, and the rest becomes so much coarser.
/// @return Whether so few faces were reached.
bool SimplifyMesh(std::size_t faces, const MeshWatch& watch, TriangleMesh* mesh);

}  // namespace livemvs
