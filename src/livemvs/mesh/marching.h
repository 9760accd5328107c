#pragma once

#include "livemvs/core/mesh.h"
#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/surface_field.h"

namespace livemvs {

/// The zeros of the field as triangles, one vertex where a line between two voxels' centres crosses
/// them. In each cell, the solid corners that no edge of the cell joins are kept apart - the same
/// on both sides of a face - and the loops of vertices are closed by triangles that meet nowhere
/// else: every edge has two triangles, or one at the grid's end, and no two triangles intersect.
TriangleMesh MarchField(const SurfaceField& field, const MeshWatch& watch);

}  // namespace livemvs
