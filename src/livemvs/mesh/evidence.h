#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "livemvs/mesh/mesh_options.h"
#include "livemvs/mesh/sight_lines.h"
#include "livemvs/mesh/voxel_blocks.h"

namespace livemvs {

/// Where the voxels of one level of the grid are: voxel v is centred at origin + h (v + 1/2).
struct VoxelFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [scene]
  double h = 0;                                      ///< Side of a voxel. [scene]
  Voxel size = Voxel::Zero();                        ///< Voxels along each axis.

  Eigen::Vector3f Center(const Voxel& v) const {
    return (origin + h * (v.cast<double>().array() + 0.5).matrix()).cast<float>();
  }
  /// In voxels; the centre of voxel v is at v + 1/2.
  Eigen::Vector3f ToGrid(const Eigen::Vector3f& point) const {
    return ((point.cast<double>() - origin) / h).cast<float>();
  }
  bool Contains(const Voxel& v) const {
    return v.minCoeff() >= 0 && (v.array() < size.array()).all();
  }
};

/// What the points say of each voxel, in units of capacity (kCapacityScale).
struct Evidence {
  std::vector<std::int16_t> solid;  ///< Lambda log-odds: > 0 solid, < 0 empty.
  std::vector<std::uint16_t> cost;  ///< rho: cost of surface in this voxel.
};

/// Capacity of a link where no point votes.
inline constexpr int kCapacityScale = 1000;
/// Evidence::solid lies within +- this.
inline constexpr int kMostEvidence = 32000;

/// Gathers the evidence of all lines of sight in the voxels that are there. Multi-threaded; sums
/// are of integers, so that the result does not depend on the number of threads.
Evidence GatherEvidence(const std::vector<SightLine>& lines,
                        const VoxelFrame& frame,
                        const VoxelBlocks& blocks,
                        const MeshOptions& options,
                        const MeshWatch& watch);

}  // namespace livemvs
