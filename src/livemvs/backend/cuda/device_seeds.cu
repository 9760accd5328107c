#include <thrust/iterator/counting_iterator.h>

#include <algorithm>
#include <cub/device/device_select.cuh>

#include "livemvs/backend/cuda/device_seeds.h"
#include "livemvs/backend/cuda/launch.h"
#include "livemvs/backend/seed_access.h"

namespace livemvs::cuda {
namespace {

constexpr std::size_t kPatchPadding = 16;  // words are read whole

struct HasEnded {
  const Fate* fate;
  __device__ bool operator()(std::uint32_t i) const {
    return fate[i] != Fate::kAlive && fate[i] != Fate::kRemoved;
  }
};

struct IsKept {
  const Fate* fate;
  __device__ bool operator()(std::uint32_t i) const { return fate[i] != Fate::kRemoved; }
};

__global__ void GatherEnded(SeedColumns s,
                            const std::uint32_t* slots,
                            std::size_t n,
                            EndedSeed* out) {
  const std::size_t thread = ThreadNumber();
  if (thread >= n) return;
  const std::uint32_t slot = slots[thread];
  out[thread] = EndOf(s, slot);
  s.fate[slot] = Fate::kRemoved;
}

__global__ void GatherStates(
    SeedColumns s, std::size_t begin, std::size_t step, std::size_t n, SeedState* out) {
  const std::size_t thread = ThreadNumber();
  if (thread >= n) return;
  out[thread] = StateOf(s, begin + thread * step);
}

__global__ void MoveSeeds(SeedColumns from,
                          const std::uint32_t* slots,
                          std::size_t n,
                          SeedColumns to) {
  const std::size_t i = ThreadNumber();
  if (i >= n) return;
  CopySeed(from, slots[i], to, i);
}

// A thread for each word of the patches, so that they are written side by side.
__global__ void MovePatches(const std::uint8_t* from,
                            const std::uint32_t* slots,
                            std::size_t n,
                            std::uint32_t* to) {
  const std::size_t first = ThreadNumber() * sizeof(std::uint32_t);
  if (first >= n * kPatchPixels) return;
  std::uint32_t word = 0;
  for (unsigned k = 0; k < sizeof word; ++k) {
    const std::size_t i = (first + k) / kPatchPixels, pixel = (first + k) % kPatchPixels;
    if (i < n) word |= std::uint32_t{from[std::size_t{slots[i]} * kPatchPixels + pixel]} << (8 * k);
  }
  to[first / sizeof word] = word;
}

}  // namespace

DeviceSeeds::Storage::Storage(std::size_t capacity)
    : mu(capacity),
      sigma2(capacity),
      a(capacity),
      b(capacity),
      c0(capacity),
      c1(capacity),
      bearing_x(capacity),
      bearing_y(capacity),
      patch(capacity * kPatchPixels + kPatchPadding),
      counts(capacity),
      fate(capacity) {}

SeedColumns DeviceSeeds::Storage::View() const {
  return {mu.get(),
          sigma2.get(),
          a.get(),
          b.get(),
          c0.get(),
          c1.get(),
          bearing_x.get(),
          bearing_y.get(),
          patch.get(),
          counts.get(),
          fate.get()};
}

void DeviceSeeds::Storage::swap(Storage& other) noexcept {
  mu.swap(other.mu);
  sigma2.swap(other.sigma2);
  a.swap(other.a);
  b.swap(other.b);
  c0.swap(other.c0);
  c1.swap(other.c1);
  bearing_x.swap(other.bearing_x);
  bearing_y.swap(other.bearing_y);
  patch.swap(other.patch);
  counts.swap(other.counts);
  fate.swap(other.fate);
}

DeviceSeeds::DeviceSeeds(std::size_t capacity, const Stream* stream)
    : capacity_(capacity),
      stream_(stream),
      storage_(capacity),
      spare_(capacity),
      columns_(storage_.View()),
      selected_(capacity),
      selected_count_(1),
      ended_count_(1) {
  std::size_t bytes = 0;
  Check(cub::DeviceSelect::If(nullptr,
                              bytes,
                              thrust::counting_iterator<std::uint32_t>(0),
                              selected_.get(),
                              selected_count_.get(),
                              static_cast<int>(capacity_),
                              HasEnded{columns_.fate},
                              stream_->get()),
        "size the selection of seeds");
  scratch_.Reserve(std::max<std::size_t>(bytes, 1));
  *ended_count_.get() = 0;
  for (const Storage* storage : {&storage_, &spare_}) {  // padding is read, too
    Check(cudaMemsetAsync(storage->patch.get(), 0, storage->patch.size(), stream_->get()),
          "clear patches");
  }
}

template <typename Predicate>
void DeviceSeeds::Select(const Predicate& predicate) {
  std::size_t bytes = scratch_.size();
  Check(cub::DeviceSelect::If(scratch_.get(),
                              bytes,
                              thrust::counting_iterator<std::uint32_t>(0),
                              selected_.get(),
                              selected_count_.get(),
                              static_cast<int>(end_),
                              predicate,
                              stream_->get()),
        "select seeds");
}

void DeviceSeeds::SelectEnded() {
  if (end_ == 0) return;
  Select(HasEnded{columns_.fate});
  Copy(selected_count_.get(), ended_count_.get(), 1, *stream_);
}

std::span<const EndedSeed> DeviceSeeds::TakeEnded() {
  const std::size_t n = *ended_count_.get();
  if (n == 0) return {};
  ended_.Reserve(n);
  ended_on_host_.Reserve(n);
  Launch("gather ended seeds",
         GatherEnded,
         BlocksFor(n),
         stream_->get(),
         columns_,
         selected_.get(),
         n,
         ended_.get());
  Copy(ended_.get(), ended_on_host_.get(), n, *stream_);
  stream_->Wait("gather ended seeds");
  *ended_count_.get() = 0;
  removed_ += n;
  return {ended_on_host_.get(), n};
}

void DeviceSeeds::Compact() {
  if (removed_ == 0) return;
  const std::size_t kept = end_ - removed_;
  Select(IsKept{columns_.fate});
  if (kept > 0) {
    const SeedColumns to = spare_.View();
    Launch("close the gaps between seeds",
           MoveSeeds,
           BlocksFor(kept),
           stream_->get(),
           columns_,
           selected_.get(),
           kept,
           to);
    Launch("close the gaps between patches",
           MovePatches,
           BlocksFor((kept * kPatchPixels + 3) / 4),
           stream_->get(),
           columns_.patch,
           selected_.get(),
           kept,
           reinterpret_cast<std::uint32_t*>(to.patch));
  }
  storage_.swap(spare_);
  columns_ = storage_.View();
  end_ = kept;
  removed_ = 0;
  if (*ended_count_.get() > 0) {  // not taken yet: they have moved
    SelectEnded();
    stream_->Wait("close the gaps between seeds");
  }
}

std::vector<SeedState> DeviceSeeds::Read(std::size_t begin, std::size_t end, std::size_t step) {
  std::vector<SeedState> seeds;
  if (begin >= end) return seeds;
  const std::size_t n = (end - begin - 1) / step + 1;
  stream_->Wait("finish before seeds are read");
  states_.Reserve(n);
  states_on_host_.Reserve(n);
  Launch("read seeds",
         GatherStates,
         BlocksFor(n),
         stream_->get(),
         columns_,
         begin,
         step,
         n,
         states_.get());
  Copy(states_.get(), states_on_host_.get(), n, *stream_);
  stream_->Wait("read seeds");
  seeds.assign(states_on_host_.get(), states_on_host_.get() + n);
  return seeds;
}

std::vector<std::uint8_t> DeviceSeeds::ReadPatches(std::size_t begin, std::size_t end) const {
  std::vector<std::uint8_t> patches((end - begin) * kPatchPixels);
  Copy(columns_.patch + begin * kPatchPixels, patches.data(), patches.size(), *stream_);
  stream_->Wait("read patches");
  return patches;
}

}  // namespace livemvs::cuda
