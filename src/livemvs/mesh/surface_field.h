#pragma once

#include <vector>

#include "livemvs/mesh/evidence.h"
#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/sight_lines.h"
#include "livemvs/mesh/volume_cut.h"
#include "livemvs/mesh/voxel_blocks.h"

namespace livemvs {

/// A function of space, sampled at the centres of voxels about its zeros, which are the surface:
/// about the distance from it in voxels, negative in what is solid.
struct SurfaceField {
  VoxelFrame frame;
  VoxelBlocks blocks;         ///< Each cell with a change of sign has its eight corners in here.
  std::vector<float> values;  ///< By the voxel's number; never 0.
};

/// The field whose zeros follow the points near the cut, and run smoothly where there are none.
/// Points count by inverse variance, as planes where they know their normals. The cut's labels
/// decide where the surface is, and its topology, to two voxels; the points, where it lies exactly.
/// Deterministic; multi-threaded.
SurfaceField MakeSurfaceField(const SightLines& sights,
                              const LabelVolume& volume,
                              const MeshOptions& options,
                              const MeshWatch& watch);

}  // namespace livemvs
