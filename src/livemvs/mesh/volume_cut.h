#pragma once

#include <cstdint>
#include <vector>

#include "livemvs/mesh/evidence.h"
#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/sight_lines.h"
#include "livemvs/mesh/voxel_blocks.h"

namespace livemvs {

/// Voxels of one size, and which of them are solid.
struct LabelLevel {
  VoxelFrame frame;
  VoxelBlocks blocks;
  std::vector<std::uint8_t> solid;  ///< 1 or 0, by the voxel's number.
};

/// Space divided into solid and empty. Level 0 is the finest, each next one has voxels twice as
/// large; the last covers the whole box, the others a band about the surface of the next.
struct LabelVolume {
  std::vector<LabelLevel> levels;

  const LabelLevel& finest() const { return levels.front(); }
  /// Whether the voxel of that level is solid, as the finest voxels say that hold it; outside of
  /// the box the nearest voxel in it answers.
  bool Solid(std::size_t level, Voxel voxel) const;
};

/// Divides space so that the lines of sight run through empty space, points have solid behind them,
/// and the surface between is small: a minimum cut (Hernandez, Vogiatzis and Cipolla,
/// "Probabilistic visibility for multi-view stereo", 2007; docs/meshing.md). The whole box is cut
/// coarsely, then a band about the surface again with voxels of half the side, in tiles that are
/// cut side by side. Deterministic; multi-threaded.
/// @throws Error (kOutOfResource) where even the smallest band needs more than options.memory_mb.
LabelVolume CutVolume(const SightLines& sights, const MeshOptions& options, const MeshWatch& watch);

}  // namespace livemvs
