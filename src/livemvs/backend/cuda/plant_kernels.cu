#include "livemvs/backend/cuda/plant_kernels.h"

#include "livemvs/backend/cuda/launch.h"
#include "livemvs/backend/seed_access.h"

namespace livemvs::cuda {
namespace {

template <typename Model>
__global__ void MarkPoints(CoverView view,
                           const CoverPoint* points,
                           std::size_t count,
                           const MarkImage* marks,
                           int levels) {
  const std::size_t i = ThreadNumber();
  if (i < count) MarkPoint<Model>(view, points[i], marks, levels);
}

__global__ void FindCandidates(ImageView<std::uint8_t> grey,
                               ImageView<std::uint8_t> marks,
                               CandidateRule rule,
                               CandidateGrid grid,
                               std::uint8_t* candidates,
                               std::uint32_t* counts) {
  __shared__ unsigned count[kPhases];
  if (threadIdx.x < kPhases) count[threadIdx.x] = 0;
  __syncthreads();
  const std::size_t i = ThreadNumber();
  if (i < grid.size()) {
    const std::uint8_t candidate = CandidateAt(grey, marks, rule, grid.X(i), grid.Y(i));
    candidates[i] = candidate;
    if (candidate > 0) atomicAdd(&count[candidate - 1], 1U);
  }
  __syncthreads();
  if (threadIdx.x < kPhases && count[threadIdx.x] > 0) {
    atomicAdd(&counts[threadIdx.x], count[threadIdx.x]);
  }
}

template <typename Model>
__device__ bool SeedOfCell(const PlantArguments& a, std::uint32_t cell, NewSeed* seed) {
  return SeedAt<Model>(*a.options, a.view, a.grid.X(cell), a.grid.Y(cell), seed);
}

template <typename Model>
__global__ void TestCells(PlantArguments a, std::uint8_t* candidates, bool* gives_seed) {
  const std::size_t i = ThreadNumber();
  if (i >= a.count) return;
  NewSeed seed;
  candidates[a.cells[i]] = 0;
  gives_seed[i] = SeedOfCell<Model>(a, a.cells[i], &seed);
}

// Seeds are made anew from their pixels: that is cheaper than to keep those of all that were
// tested.
template <typename Model>
__global__ void StartSeeds(PlantArguments a,
                           SeedColumns seeds,
                           std::size_t begin,
                           Posterior<float> prior) {
  const std::size_t i = ThreadNumber();
  if (i >= a.count) return;
  NewSeed seed;
  if (SeedOfCell<Model>(a, a.cells[i], &seed)) StartSeed(seeds, begin + i, seed, prior);
}

}  // namespace

void LaunchMarkPoints(const CoverView& view,
                      const CoverPoint* points,
                      std::size_t count,
                      const MarkImage* marks,
                      int levels,
                      CameraModel model,
                      cudaStream_t stream) {
  VisitModel(model, [&](auto m) {
    Launch("mark points",
           MarkPoints<decltype(m)>,
           BlocksFor(count),
           stream,
           view,
           points,
           count,
           marks,
           levels);
  });
}

void LaunchFindCandidates(const ImageView<std::uint8_t>& grey,
                          const ImageView<std::uint8_t>& marks,
                          const CandidateRule& rule,
                          const CandidateGrid& grid,
                          std::uint8_t* candidates,
                          std::uint32_t* counts,
                          cudaStream_t stream) {
  Launch("find candidates",
         FindCandidates,
         BlocksFor(grid.size()),
         stream,
         grey,
         marks,
         rule,
         grid,
         candidates,
         counts);
}

void LaunchTestCells(const PlantArguments& arguments,
                     CameraModel model,
                     std::uint8_t* candidates,
                     bool* gives_seed,
                     cudaStream_t stream) {
  VisitModel(model, [&](auto m) {
    Launch("test candidates",
           TestCells<decltype(m)>,
           BlocksFor(arguments.count),
           stream,
           arguments,
           candidates,
           gives_seed);
  });
}

void LaunchStartSeeds(const PlantArguments& arguments,
                      CameraModel model,
                      const SeedColumns& seeds,
                      std::size_t begin,
                      const Posterior<float>& prior,
                      cudaStream_t stream) {
  VisitModel(model, [&](auto m) {
    Launch("start seeds",
           StartSeeds<decltype(m)>,
           BlocksFor(arguments.count),
           stream,
           arguments,
           seeds,
           begin,
           prior);
  });
}

}  // namespace livemvs::cuda
