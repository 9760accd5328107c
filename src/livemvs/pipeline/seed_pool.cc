#include "livemvs/pipeline/seed_pool.h"

#include <cassert>
#include <cstring>

namespace livemvs {

template <typename T>
T* SeedPool::Column(std::vector<std::vector<std::byte>>& storage,
                    std::size_t per_seed,
                    std::size_t padding) {
  storage.emplace_back(capacity_ * per_seed * sizeof(T) + padding);
  return reinterpret_cast<T*>(storage.back().data());
}

SeedPool::SeedPool(std::size_t capacity) : capacity_(capacity) {
  columns_.mu = Column<float>(storage_, 1, 0);
  columns_.sigma2 = Column<float>(storage_, 1, 0);
  columns_.a = Column<float>(storage_, 1, 0);
  columns_.b = Column<float>(storage_, 1, 0);
  columns_.c0 = Column<float>(storage_, 1, 0);
  columns_.c1 = Column<float>(storage_, 1, 0);
  columns_.bearing_x = Column<float>(storage_, 1, 0);
  columns_.bearing_y = Column<float>(storage_, 1, 0);
  columns_.patch = Column<std::uint8_t>(storage_, kPatchPixels, 8);
  columns_.counts = Column<SeedCounts>(storage_, 1, 0);
  columns_.fate = Column<Fate>(storage_, 1, 0);
}

void SeedPool::BeginReference(std::int64_t frame_index,
                              int level,
                              const Camera& camera,
                              const Rigid3d& cam_from_world) {
  references_.push_back({end_, end_, frame_index, level, camera, cam_from_world});
}

void SeedPool::EndReference() {
  if (references_.back().begin == references_.back().end) references_.pop_back();
}

void SeedPool::Add(const NewSeed& seed, const Posterior<float>& prior) {
  assert(end_ < capacity_ && !references_.empty());
  const std::size_t i = end_++;
  columns_.mu[i] = prior.mu;
  columns_.sigma2[i] = prior.sigma2;
  columns_.a[i] = prior.a;
  columns_.b[i] = prior.b;
  columns_.c0[i] = seed.interval.c0;
  columns_.c1[i] = seed.interval.c1;
  columns_.bearing_x[i] = seed.bearing_x;
  columns_.bearing_y[i] = seed.bearing_y;
  for (int r = 0; r < kPatchSize; ++r) {
    std::memcpy(columns_.patch + i * kPatchPixels + r * kPatchSize,
                seed.patch + (r - kPatchRadius) * seed.stride - kPatchRadius,
                kPatchSize);
  }
  columns_.counts[i] = {0, 0, 0};
  columns_.fate[i] = Fate::kAlive;
  references_.back().end = end_;
  ++alive_;
}

void SeedPool::Remove(std::size_t i) {
  assert(i < end_ && columns_.fate[i] != Fate::kRemoved);
  columns_.fate[i] = Fate::kRemoved;
  --alive_;
}

void SeedPool::Move(std::size_t from, std::size_t to) {
  columns_.mu[to] = columns_.mu[from];
  columns_.sigma2[to] = columns_.sigma2[from];
  columns_.a[to] = columns_.a[from];
  columns_.b[to] = columns_.b[from];
  columns_.c0[to] = columns_.c0[from];
  columns_.c1[to] = columns_.c1[from];
  columns_.bearing_x[to] = columns_.bearing_x[from];
  columns_.bearing_y[to] = columns_.bearing_y[from];
  std::memcpy(
      columns_.patch + to * kPatchPixels, columns_.patch + from * kPatchPixels, kPatchPixels);
  columns_.counts[to] = columns_.counts[from];
  columns_.fate[to] = columns_.fate[from];
}

void SeedPool::Compact() {
  if (alive_ == end_) return;
  std::size_t to = 0;
  std::vector<ReferenceFrame> kept;
  kept.reserve(references_.size());
  for (const ReferenceFrame& reference : references_) {
    ReferenceFrame moved = reference;
    moved.begin = to;
    for (std::size_t i = reference.begin; i < reference.end; ++i) {
      if (columns_.fate[i] == Fate::kRemoved) continue;
      if (i != to) Move(i, to);
      ++to;
    }
    moved.end = to;
    if (moved.begin != moved.end) kept.push_back(moved);
  }
  references_ = std::move(kept);
  end_ = to;
  assert(alive_ == end_);
}

}  // namespace livemvs
