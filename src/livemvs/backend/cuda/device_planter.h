#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cuda/device_memory.h"
#include "livemvs/backend/cuda/device_seeds.h"
#include "livemvs/backend/cuda/plant_kernels.h"
#include "livemvs/backend/cuda/seed_kernels.h"
#include "livemvs/backend/planting.h"

namespace livemvs::cuda {

/// What the points cover with, in the device's memory, which grows with them.
class DevicePoints {
 public:
  /// Begins to copy what is new of the points: those of the last call, and others after them.
  const CoverPoint* Extend(std::span<const Point> points, const Stream& stream);

  void Forget() { size_ = 0; }

 private:
  std::size_t size_ = 0;
  DeviceArray<CoverPoint> points_;
  PinnedArray<CoverPoint> staging_;
};

/// Step 1 of Algorithm 1 on the device; see Backend. Only counts come back: of the candidates by
/// phase, and of the seeds of each round. Memory is for pictures of the largest size so far.
class DevicePlanter {
 public:
  /// @param options, stream  Must outlive it.
  DevicePlanter(const Options& options, const Stream* stream)
      : options_(options),
        stream_(*stream),
        counts_(kPhases),
        counts_on_host_(kPhases),
        chosen_count_(1),
        chosen_count_on_host_(1) {}

  /// @param pyramid    The current frame; the pictures are on the device.
  /// @param arguments  Of the planting's groups.
  std::vector<std::size_t> Plant(const Planting& planting,
                                 std::span<const CurrentImage> pyramid,
                                 const KernelArguments& arguments,
                                 DeviceSeeds* seeds);

  void ForgetPoints() { points_.Forget(); }

 private:
  void Reserve(const ImageView<std::uint8_t>& finest);
  void MarkKnown(const Planting& planting,
                 std::span<const CurrentImage> pyramid,
                 const KernelArguments& arguments);
  PhaseCounts FindCandidates(const ImageView<std::uint8_t>& grey,
                             const ImageView<std::uint8_t>& marks,
                             const CandidateRule& rule,
                             const CandidateGrid& grid);
  std::size_t PlantLevel(const Planting& planting,
                         int level,
                         const ImageView<std::uint8_t>& grey,
                         const Options* options_on_device,
                         DeviceSeeds* seeds);
  void SelectOffered(const Share& share, int cells);
  std::size_t SelectChosen(std::size_t offered);

  const Options& options_;
  const Stream& stream_;
  DevicePoints points_;
  DeviceArray<std::uint8_t> mark_pixels_;
  Table<MarkImage> marks_;                // by level
  DeviceArray<std::uint8_t> candidates_;  // 1 + phase of each cell of the grid, or 0
  DeviceArray<std::uint32_t> counts_;     // by phase
  PinnedArray<std::uint32_t> counts_on_host_;
  DeviceArray<std::uint32_t> ranks_;    // of each cell among those of the phase that is shared
  DeviceArray<std::uint32_t> offered_;  // cells
  DeviceArray<bool> gives_seed_;        // of those offered
  DeviceArray<std::uint32_t> chosen_;   // cells that become seeds
  DeviceArray<std::uint32_t> chosen_count_;
  PinnedArray<std::uint32_t> chosen_count_on_host_;
  DeviceArray<std::uint8_t> scratch_;  // of CUB
};

}  // namespace livemvs::cuda
