#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "livemvs/backend/cuda/device_memory.h"
#include "livemvs/backend/seed_columns.h"
#include "livemvs/backend/seed_state.h"

namespace livemvs::cuda {

/// The seeds in the device's memory, from birth to conversion. Memory is allocated once, but for
/// what carries ended seeds to the host, which grows to the most that ended in one frame.
class DeviceSeeds {
 public:
  /// @throws DeviceError where the device's memory is too small.
  DeviceSeeds(std::size_t capacity, const Stream* stream);

  std::size_t capacity() const { return capacity_; }
  const SeedColumns& columns() const { return columns_; }
  /// Slots behind the last seed.
  std::size_t room() const { return capacity_ - end_; }

  /// Counts the next `count` slots, for which there is room, as seeds, and returns the first: the
  /// caller begins to write them.
  std::size_t Extend(std::size_t count) { return std::exchange(end_, end_ + count); }

  /// Begins to look for the seeds that ended; TakeEnded() may be called after the stream's work is
  /// done.
  void SelectEnded();

  // See Backend.
  std::span<const EndedSeed> TakeEnded();
  void Compact();
  std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step);
  std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) const;

 private:
  /// One array per quantity.
  struct Storage {
    explicit Storage(std::size_t capacity);
    SeedColumns View() const;
    void swap(Storage& other) noexcept;

    DeviceArray<float> mu, sigma2, a, b, c0, c1, bearing_x, bearing_y;
    DeviceArray<std::uint8_t> patch;
    DeviceArray<SeedCounts> counts;
    DeviceArray<Fate> fate;
  };

  template <typename Predicate>
  void Select(const Predicate& predicate);

  std::size_t capacity_;
  const Stream* stream_;
  std::size_t end_ = 0;      // one past the last slot in use
  std::size_t removed_ = 0;  // of those before it
  Storage storage_, spare_;
  SeedColumns columns_;
  DeviceArray<std::uint32_t> selected_;  // slots
  DeviceArray<std::uint8_t> scratch_;    // of the selection
  DeviceArray<std::uint32_t> selected_count_;
  PinnedArray<std::uint32_t> ended_count_;
  DeviceArray<EndedSeed> ended_;
  PinnedArray<EndedSeed> ended_on_host_;
  DeviceArray<SeedState> states_;
  PinnedArray<SeedState> states_on_host_;
};

}  // namespace livemvs::cuda
