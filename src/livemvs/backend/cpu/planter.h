#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cpu/candidates.h"
#include "livemvs/backend/cpu/coverage.h"
#include "livemvs/backend/cpu/host_seeds.h"
#include "livemvs/backend/cpu/kernels.h"
#include "livemvs/backend/planting.h"

namespace livemvs {

/// Step 1 of Algorithm 1 on the CPU; see Backend. Buffers are kept between frames.
class Planter {
 public:
  /// @param options  Must outlive it.
  Planter(const Options& options, MarkKernel mark)
      : options_(options), mark_(mark), coverage_(options.cover_angle_deg) {}

  std::vector<std::size_t> Plant(const Planting& planting,
                                 std::span<const ImageView<std::uint8_t>> pyramid,
                                 HostSeeds* seeds);

  void ForgetPoints() { coverage_.Forget(); }

 private:
  // A pixel that is offered, and the seed it becomes, if any.
  struct Offer {
    int x, y;
    bool gives_seed;
    NewSeed seed;
  };

  void MarkKnown(const Planting& planting, const SeedColumns& seeds);
  std::size_t PlantLevel(const Planting& planting,
                         int level,
                         const ImageView<std::uint8_t>& grey,
                         HostSeeds* seeds);
  template <typename Model>
  std::size_t PlantShare(const PlantView& view, const Share& share, HostSeeds* seeds);
  template <typename Model>
  std::size_t PlantOffers(const PlantView& view, HostSeeds* seeds);

  const Options& options_;
  MarkKernel mark_;
  Coverage coverage_;
  Candidates candidates_;
  std::vector<Offer> offers_;  // some thousand at a time
};

}  // namespace livemvs
