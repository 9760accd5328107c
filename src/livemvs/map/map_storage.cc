#include "livemvs/map/map_storage.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

namespace livemvs {
namespace {

constexpr float kNormalScale = 32767;
constexpr float kFootprintSteps = 14;
constexpr float kFootprintZero = 15;

float SignOf(float v) { return v < 0 ? -1.0F : 1.0F; }

}  // namespace

std::array<std::int16_t, 2> EncodeNormal(const Eigen::Vector3f& normal) {
  const float sum = normal.lpNorm<1>();
  if (!(sum > 0) || !std::isfinite(sum)) return {0, 0};
  float u = normal.x() / sum, v = normal.y() / sum;
  if (normal.z() < 0) {
    const float folded = (1 - std::abs(v)) * SignOf(u);
    v = (1 - std::abs(u)) * SignOf(v);
    u = folded;
  }
  const auto code = [](float c) {
    return static_cast<std::int16_t>(c * kNormalScale + (c < 0 ? -0.5F : 0.5F));
  };
  return {code(u), code(v)};
}

Eigen::Vector3f DecodeNormal(const std::array<std::int16_t, 2>& code) {
  const float u = static_cast<float>(code[0]) / kNormalScale;
  const float v = static_cast<float>(code[1]) / kNormalScale;
  Eigen::Vector3f n(u, v, 1 - std::abs(u) - std::abs(v));
  if (n.z() < 0) {
    n.x() = (1 - std::abs(v)) * SignOf(u);
    n.y() = (1 - std::abs(u)) * SignOf(v);
  }
  return n.normalized();
}

std::uint8_t EncodeFootprint(float footprint, float spacing) {
  if (!(footprint > 0)) return 0;
  const float code = kFootprintZero + kFootprintSteps * std::log2(footprint / spacing);
  return static_cast<std::uint8_t>(std::lround(std::clamp(code, 1.0F, 255.0F)));
}

float DecodeFootprint(std::uint8_t code, float spacing) {
  return code == 0
             ? 0
             : spacing * std::exp2((static_cast<float>(code) - kFootprintZero) / kFootprintSteps);
}

StoredPoint* PointArena::Allocate(std::size_t count, std::uint16_t* capacity) {
  const auto at = std::lower_bound(kCapacities.begin(), kCapacities.end(), count);
  assert(at != kCapacities.end());
  const auto first = static_cast<std::size_t>(at - kCapacities.begin());
  const std::size_t last = thrifty_ ? kCapacities.size() : first + 1;
  for (std::size_t size = first; size < last; ++size) {
    if (free_[size].empty()) continue;
    StoredPoint* points = free_[size].back();
    free_[size].pop_back();
    *capacity = kCapacities[size];
    return points;
  }
  *capacity = *at;
  if (used_ + *capacity > kChunkPoints) {
    // What is left of the last piece is lost: less than 2 % of it.
    chunks_.emplace_back(new StoredPoint[kChunkPoints]);
    used_ = 0;
  }
  StoredPoint* points = chunks_.back().get() + used_;
  used_ += *capacity;
  return points;
}

void PointArena::Free(StoredPoint* points, std::uint16_t capacity) {
  const auto at = std::lower_bound(kCapacities.begin(), kCapacities.end(), capacity);
  free_[static_cast<std::size_t>(at - kCapacities.begin())].push_back(points);
}

const StoredPoint* MapBlock::Add(int x, int y, int z, const StoredPoint& point, PointArena* arena) {
  const std::uint64_t bit = std::uint64_t{1} << (kSide * y + x);
  assert((mask[z] & bit) == 0);
  const std::size_t rank = Rank(z, bit);
  if (count == capacity) {
    std::uint16_t larger = 0;
    StoredPoint* moved = arena->Allocate(std::size_t{count} + 1, &larger);
    std::copy(points, points + rank, moved);
    std::copy(points + rank, points + count, moved + rank + 1);
    if (points != nullptr) arena->Free(points, capacity);
    points = moved;
    capacity = larger;
  } else {
    std::copy_backward(points + rank, points + count, points + count + 1);
  }
  points[rank] = point;
  mask[z] |= bit;
  ++count;
  for (int w = z + 1; w < kSide; ++w) ++before[w];
  return points + rank;
}

void MapBlock::Remove(int x, int y, int z) {
  const std::uint64_t bit = std::uint64_t{1} << (kSide * y + x);
  assert(mask[z] & bit);
  const std::size_t rank = Rank(z, bit);
  std::copy(points + rank + 1, points + count, points + rank);
  mask[z] &= ~bit;
  --count;
  for (int w = z + 1; w < kSide; ++w) --before[w];
}

void MapBlock::Clear(PointArena* arena) {
  if (points != nullptr) arena->Free(points, capacity);
  *this = MapBlock{.key = key};
}

std::uint32_t BlockTable::Search(std::uint64_t key) const {
  if (entries_.empty()) return kNone;
  const std::size_t mask = entries_.size() - 1;
  std::size_t i = Hash(key) & mask;
  while (entries_[i].block != kNone && entries_[i].key != key) i = (i + 1) & mask;
  return entries_[i].block;
}

void BlockTable::Insert(std::uint64_t key, std::uint32_t block) {
  if (2 * (used_ + 1) > entries_.size()) Grow();
  Place({key, block});
  ++used_;
  recent_[Hash(key) % kRecent] = {key, block};
}

void BlockTable::Place(const Entry& entry) {
  const std::size_t mask = entries_.size() - 1;
  std::size_t i = Hash(entry.key) & mask;
  while (entries_[i].block != kNone) i = (i + 1) & mask;
  entries_[i] = entry;
}

void BlockTable::Clear() { *this = {}; }

void BlockTable::Grow() {
  std::vector<Entry> old(std::max<std::size_t>(64, 2 * entries_.size()));
  old.swap(entries_);
  for (const Entry& entry : old) {
    if (entry.block != kNone) Place(entry);
  }
}

}  // namespace livemvs
