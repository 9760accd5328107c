#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <type_traits>

#include "livemvs/backend/cover_rule.h"
#include "livemvs/backend/plant_rule.h"
#include "livemvs/backend/seed_columns.h"
#include "livemvs/core/posterior.h"

namespace livemvs::cuda {

/// Pixels of a frame that may become seeds; pointers are the device's.
struct PlantArguments {
  const Options* options;
  PlantView view;
  CandidateGrid grid;
  const std::uint32_t* cells;  ///< Which entries of the grid: `count` of them.
  std::size_t count;
};

static_assert(std::is_trivially_copyable_v<PlantArguments> &&
              std::is_trivially_copyable_v<CoverView> && std::is_trivially_copyable_v<Share>);

// Each begins its work in the stream.

/// Marks what `count` points cover; `marks` has a picture for each of the levels.
void LaunchMarkPoints(const CoverView& view,
                      const CoverPoint* points,
                      std::size_t count,
                      const MarkImage* marks,
                      int levels,
                      CameraModel model,
                      cudaStream_t stream);

/// Writes CandidateAt() of each entry of the grid, and adds to the number of candidates by phase.
void LaunchFindCandidates(const ImageView<std::uint8_t>& grey,
                          const ImageView<std::uint8_t>& marks,
                          const CandidateRule& rule,
                          const CandidateGrid& grid,
                          std::uint8_t* candidates,
                          std::uint32_t* counts,
                          cudaStream_t stream);

/// Whether each of the cells gives a seed; they are candidates no longer.
void LaunchTestCells(const PlantArguments& arguments,
                     CameraModel model,
                     std::uint8_t* candidates,
                     bool* gives_seed,
                     cudaStream_t stream);

/// Writes the seeds that the cells, all of which give one, become, from slot `begin` on.
void LaunchStartSeeds(const PlantArguments& arguments,
                      CameraModel model,
                      const SeedColumns& seeds,
                      std::size_t begin,
                      const Posterior<float>& prior,
                      cudaStream_t stream);

}  // namespace livemvs::cuda
