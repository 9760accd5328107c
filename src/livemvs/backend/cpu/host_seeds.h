#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "livemvs/backend/seed_columns.h"
#include "livemvs/backend/seed_state.h"

namespace livemvs {

/// The seeds in the host's memory, which is allocated once. Not thread-safe.
class HostSeeds {
 public:
  explicit HostSeeds(std::size_t capacity);

  std::size_t capacity() const { return capacity_; }
  const SeedColumns& columns() const { return columns_; }
  /// Slots that may be appended to.
  std::size_t room() const { return capacity_ - end_; }

  /// Puts a newborn seed behind those that are there, where there is room.
  void Append(const NewSeed& seed, const Posterior<float>& prior);

  // See Backend.
  std::span<const EndedSeed> TakeEnded();
  void Compact();
  std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) const;
  std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) const;

 private:
  template <typename T>
  T* Column(std::size_t per_seed, std::size_t padding);
  void Move(std::size_t from, std::size_t to);

  std::size_t capacity_;
  std::size_t end_ = 0;      // one past the last slot in use
  std::size_t removed_ = 0;  // of those before it
  std::vector<std::vector<std::byte>> storage_;
  SeedColumns columns_;
  std::vector<EndedSeed> ended_;
};

}  // namespace livemvs
