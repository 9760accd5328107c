#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>

#include <algorithm>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>

#include "livemvs/backend/cuda/device_planter.h"

namespace livemvs::cuda {
namespace {

constexpr std::size_t kChunk = 1 << 16;  // points that are copied together

using Cells = thrust::counting_iterator<std::uint32_t>;

struct IsOfPhase {
  const std::uint8_t* candidates;
  int phase;
  __host__ __device__ std::uint32_t operator()(std::uint32_t cell) const {
    return candidates[cell] == phase + 1 ? 1 : 0;
  }
};

struct IsOffered {
  const std::uint8_t* candidates;
  const std::uint32_t* ranks;  // of those of the phase of which the share takes some
  Share share;
  __host__ __device__ bool operator()(std::uint32_t cell) const {
    const int phase = candidates[cell] - 1;
    return phase >= 0 && share.Offers(phase, phase == share.whole ? ranks[cell] : 0);
  }
};

// Each is called twice: without memory it tells how much it needs.

cudaError_t Rank(void* scratch,
                 std::size_t* bytes,
                 const IsOfPhase& is_of_phase,
                 int cells,
                 std::uint32_t* ranks,
                 const Stream& stream) {
  return cub::DeviceScan::ExclusiveSum(scratch,
                                       *bytes,
                                       thrust::make_transform_iterator(Cells(0), is_of_phase),
                                       ranks,
                                       cells,
                                       stream.get());
}

cudaError_t Select(void* scratch,
                   std::size_t* bytes,
                   const IsOffered& is_offered,
                   int cells,
                   std::uint32_t* selected,
                   std::uint32_t* count,
                   const Stream& stream) {
  return cub::DeviceSelect::If(
      scratch, *bytes, Cells(0), selected, count, cells, is_offered, stream.get());
}

cudaError_t Select(void* scratch,
                   std::size_t* bytes,
                   const std::uint32_t* from,
                   const bool* flags,
                   int size,
                   std::uint32_t* selected,
                   std::uint32_t* count,
                   const Stream& stream) {
  return cub::DeviceSelect::Flagged(
      scratch, *bytes, from, flags, selected, count, size, stream.get());
}

}  // namespace

const CoverPoint* DevicePoints::Extend(std::span<const Point> points, const Stream& stream) {
  Grow(points.size(), size_, stream, &points_);
  while (size_ < points.size()) {
    const auto added = points.subspan(size_, std::min(kChunk, points.size() - size_));
    stream.Wait("copy points");  // the staging memory is free again
    staging_.Reserve(added.size());
    std::ranges::transform(added, staging_.get(), CoverPointOf);
    Copy(staging_.get(), points_.get() + size_, added.size(), stream);
    size_ += added.size();
  }
  return points_.get();
}

std::vector<std::size_t> DevicePlanter::Plant(const Planting& planting,
                                              std::span<const CurrentImage> pyramid,
                                              const KernelArguments& arguments,
                                              DeviceSeeds* seeds) {
  Reserve(pyramid[0].grey);
  MarkKnown(planting, pyramid, arguments);
  std::vector<std::size_t> planted(pyramid.size());
  // Coarse seeds first: they are few.
  for (std::size_t l = pyramid.size(); l-- > 0;) {
    planted[l] =
        PlantLevel(planting, static_cast<int>(l), pyramid[l].grey, arguments.options, seeds);
  }
  stream_.Wait("plant seeds");
  return planted;
}

void DevicePlanter::Reserve(const ImageView<std::uint8_t>& finest) {
  const CandidateRule everywhere = {
      {0, 0, finest.width, finest.height}, options_.seed_spacing_px, 0, 0};
  const std::size_t cells = MakeCandidateGrid(everywhere).size();
  if (cells <= candidates_.size()) return;
  ranks_.Reserve(cells);
  offered_.Reserve(cells);
  gives_seed_.Reserve(cells);
  chosen_.Reserve(cells);
  const int n = static_cast<int>(ranks_.size());
  std::size_t rank = 0, offer = 0, choose = 0;
  Check(Rank(nullptr, &rank, {}, n, ranks_.get(), stream_), "size the ranking of candidates");
  Check(Select(nullptr, &offer, {}, n, offered_.get(), chosen_count_.get(), stream_),
        "size the selection of candidates");
  Check(Select(nullptr,
               &choose,
               offered_.get(),
               gives_seed_.get(),
               n,
               chosen_.get(),
               chosen_count_.get(),
               stream_),
        "size the selection of newborn seeds");
  scratch_.Reserve(std::max({rank, offer, choose, std::size_t{1}}));
  candidates_.Reserve(cells);  // last: what it holds tells that there is room for all
}

void DevicePlanter::MarkKnown(const Planting& planting,
                              std::span<const CurrentImage> pyramid,
                              const KernelArguments& arguments) {
  MarkImage* marks = marks_.Fill(pyramid.size());
  std::size_t pixels = 0;
  for (const CurrentImage& level : pyramid) pixels += level.grey.stride * level.grey.height;
  mark_pixels_.Reserve(pixels);
  std::uint8_t* begin = mark_pixels_.get();
  for (const CurrentImage& level : pyramid) {
    const ImageView<std::uint8_t>& grey = level.grey;
    *marks++ = {begin, grey.width, grey.height, grey.stride};
    begin += grey.stride * grey.height;
  }
  if (options_.cover_radius_px < 0) return;
  const CameraModel model = planting.frame.camera.model;
  const MarkImage* on_device = marks_.Upload(pyramid.size(), stream_);
  Check(cudaMemsetAsync(mark_pixels_.get(), 0, pixels, stream_.get()), "clear marks");
  if (arguments.block_count > 0) {
    LaunchMark(arguments, options_.coordinate, on_device, model, stream_.get());
  }
  const CoverPoint* points = points_.Extend(planting.points, stream_);
  if (!planting.points.empty()) {
    LaunchMarkPoints(MakeCoverView(planting.frame, options_.cover_angle_deg),
                     points,
                     planting.points.size(),
                     on_device,
                     static_cast<int>(pyramid.size()),
                     model,
                     stream_.get());
  }
}

PhaseCounts DevicePlanter::FindCandidates(const ImageView<std::uint8_t>& grey,
                                          const ImageView<std::uint8_t>& marks,
                                          const CandidateRule& rule,
                                          const CandidateGrid& grid) {
  Check(cudaMemsetAsync(counts_.get(), 0, kPhases * sizeof(std::uint32_t), stream_.get()),
        "clear counts");
  LaunchFindCandidates(grey, marks, rule, grid, candidates_.get(), counts_.get(), stream_.get());
  Copy(counts_.get(), counts_on_host_.get(), kPhases, stream_);
  stream_.Wait("find candidates");
  PhaseCounts counts;
  std::copy_n(counts_on_host_.get(), kPhases, counts.begin());
  return counts;
}

std::size_t DevicePlanter::PlantLevel(const Planting& planting,
                                      int level,
                                      const ImageView<std::uint8_t>& grey,
                                      const Options* options_on_device,
                                      DeviceSeeds* seeds) {
  const CandidateRule rule = MakeCandidateRule(options_, planting, level);
  const CandidateGrid grid = MakeCandidateGrid(rule);
  if (grid.size() == 0) return 0;
  const CameraModel model = planting.frame.camera.model;
  const PhaseCounts counts = FindCandidates(grey, marks_.host()[level].view(), rule, grid);
  PlantArguments arguments = {
      options_on_device, MakePlantView(options_, planting, level, grey), grid, nullptr, 0};
  return PlantInRounds(counts, seeds->room(), [&](const Share& share, std::size_t free) {
    SelectOffered(share, static_cast<int>(grid.size()));
    arguments.cells = offered_.get();
    arguments.count = share.size;
    LaunchTestCells(arguments, model, candidates_.get(), gives_seed_.get(), stream_.get());
    arguments.cells = chosen_.get();
    arguments.count = std::min(SelectChosen(share.size), free);
    if (arguments.count > 0) {
      LaunchStartSeeds(arguments,
                       model,
                       seeds->columns(),
                       seeds->Extend(arguments.count),
                       PriorOf(options_),
                       stream_.get());
    }
    return arguments.count;
  });
}

// Writes the cells that the share offers, row by row.
void DevicePlanter::SelectOffered(const Share& share, int cells) {
  std::size_t bytes = scratch_.size();
  if (share.whole < kPhases) {
    Check(
        Rank(
            scratch_.get(), &bytes, {candidates_.get(), share.whole}, cells, ranks_.get(), stream_),
        "rank candidates");
  }
  Check(Select(scratch_.get(),
               &bytes,
               {candidates_.get(), ranks_.get(), share},
               cells,
               offered_.get(),
               chosen_count_.get(),
               stream_),
        "select candidates");
}

// Writes those of the cells on offer that give a seed, and returns how many.
std::size_t DevicePlanter::SelectChosen(std::size_t offered) {
  std::size_t bytes = scratch_.size();
  Check(Select(scratch_.get(),
               &bytes,
               offered_.get(),
               gives_seed_.get(),
               static_cast<int>(offered),
               chosen_.get(),
               chosen_count_.get(),
               stream_),
        "select newborn seeds");
  Copy(chosen_count_.get(), chosen_count_on_host_.get(), 1, stream_);
  stream_.Wait("select newborn seeds");
  return *chosen_count_on_host_.get();
}

}  // namespace livemvs::cuda
