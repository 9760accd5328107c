#include "livemvs/backend/cpu/host_seeds.h"

#include <cassert>
#include <cstring>

#include "livemvs/backend/seed_access.h"

namespace livemvs {
namespace {

// The first seed from i on that is not simply alive, or `end`.
std::size_t SkipAlive(const Fate* fate, std::size_t i, std::size_t end) {
  static_assert(sizeof(Fate) == 1 && static_cast<int>(Fate::kAlive) == 0);
  std::uint64_t eight = 0;
  while (i + sizeof eight <= end) {
    std::memcpy(&eight, fate + i, sizeof eight);
    if (eight != 0) break;
    i += sizeof eight;
  }
  while (i < end && fate[i] == Fate::kAlive) ++i;
  return i;
}

}  // namespace

template <typename T>
T* HostSeeds::Column(std::size_t per_seed, std::size_t padding) {
  storage_.emplace_back(capacity_ * per_seed * sizeof(T) + padding);
  return reinterpret_cast<T*>(storage_.back().data());
}

HostSeeds::HostSeeds(std::size_t capacity) : capacity_(capacity) {
  columns_.mu = Column<float>(1, 0);
  columns_.sigma2 = Column<float>(1, 0);
  columns_.a = Column<float>(1, 0);
  columns_.b = Column<float>(1, 0);
  columns_.c0 = Column<float>(1, 0);
  columns_.c1 = Column<float>(1, 0);
  columns_.bearing_x = Column<float>(1, 0);
  columns_.bearing_y = Column<float>(1, 0);
  columns_.patch = Column<std::uint8_t>(kPatchPixels, 8);
  columns_.counts = Column<SeedCounts>(1, 0);
  columns_.fate = Column<Fate>(1, 0);
}

void HostSeeds::Append(const NewSeed& seed, const Posterior<float>& prior) {
  assert(room() > 0);
  StartSeed(columns_, end_++, seed, prior);
}

std::span<const EndedSeed> HostSeeds::TakeEnded() {
  ended_.clear();
  for (std::size_t i = 0; i < end_; ++i) {
    i = SkipAlive(columns_.fate, i, end_);
    if (i == end_) break;
    if (columns_.fate[i] == Fate::kRemoved) continue;
    ended_.push_back(EndOf(columns_, i));
    columns_.fate[i] = Fate::kRemoved;
  }
  removed_ += ended_.size();
  return ended_;
}

void HostSeeds::Move(std::size_t from, std::size_t to) {
  CopySeed(columns_, from, columns_, to);
  std::memcpy(
      columns_.patch + to * kPatchPixels, columns_.patch + from * kPatchPixels, kPatchPixels);
}

void HostSeeds::Compact() {
  if (removed_ == 0) return;
  std::size_t to = 0;
  for (std::size_t i = 0; i < end_; ++i) {
    if (columns_.fate[i] == Fate::kRemoved) continue;
    if (i != to) Move(i, to);
    ++to;
  }
  assert(end_ - to == removed_);
  end_ = to;
  removed_ = 0;
}

std::vector<SeedState> HostSeeds::Read(std::size_t begin, std::size_t end, std::size_t step) const {
  std::vector<SeedState> seeds;
  seeds.reserve((end - begin) / step + 1);
  for (std::size_t i = begin; i < end; i += step) seeds.push_back(StateOf(columns_, i));
  return seeds;
}

std::vector<std::uint8_t> HostSeeds::ReadPatches(std::size_t begin, std::size_t end) const {
  return {columns_.patch + begin * kPatchPixels, columns_.patch + end * kPatchPixels};
}

}  // namespace livemvs
