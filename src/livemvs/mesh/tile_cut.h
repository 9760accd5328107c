#pragma once

#include <cstdint>
#include <vector>

#include "livemvs/mesh/evidence.h"
#include "livemvs/mesh/volume_cut.h"

namespace livemvs {

/// The labels of a level's voxels by minimum cut, written to volume->levels[level].solid. Voxels
/// beside the level's keep the label of the coarser levels. The coarsest is cut as one, others in
/// tiles, each with a margin about it.
void CutLevel(std::size_t level,
              const Evidence& evidence,
              const MeshWatch& watch,
              LabelVolume* volume);

}  // namespace livemvs
