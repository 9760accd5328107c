#pragma once

#include <cstddef>
#include <vector>

#include "livemvs/backend/seed_columns.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// A seed at its birth.
struct NewSeed {
  Interval<float> interval;
  float bearing_x;
  float bearing_y;
  const std::uint8_t* patch;  ///< Centre pixel in the grey image ...
  std::ptrdiff_t stride;      ///< ... whose rows are this far apart.
};

/// Seeds born in the same frame at the same level of its pyramid: entries [begin, end) of the pool.
struct ReferenceFrame {
  std::size_t begin;
  std::size_t end;
  std::int64_t frame_index;
  int level;
  Camera camera;  ///< At that level.
  Rigid3d cam_from_world;
};

/// The M seeds of Algorithm 1 as structure of arrays, grouped by reference frame in order of birth.
/// Memory is allocated once. Not thread-safe.
class SeedPool {
 public:
  explicit SeedPool(std::size_t capacity);

  std::size_t capacity() const { return capacity_; }
  /// Seeds alive. [VH11] S.
  std::size_t size() const { return alive_; }
  /// Of which those that removed seeds left are usable after Compact() only.
  std::size_t free_slots() const { return capacity_ - alive_; }
  const std::vector<ReferenceFrame>& references() const { return references_; }
  const SeedColumns& columns() const { return columns_; }

  /// Opens a new group; Add() appends to it.
  void BeginReference(std::int64_t frame_index,
                      int level,
                      const Camera& camera,
                      const Rigid3d& cam_from_world);

  /// Closes the group; one without seeds goes.
  void EndReference();

  /// Appends a seed with the posterior `prior`; the pool must have a free slot.
  void Add(const NewSeed& seed, const Posterior<float>& prior);

  /// Marks seed i as gone; its slot is free after the next Compact().
  void Remove(std::size_t i);

  /// Closes the gaps that removed seeds left; order is kept, empty groups go.
  void Compact();

 private:
  template <typename T>
  T* Column(std::vector<std::vector<std::byte>>& storage,
            std::size_t per_seed,
            std::size_t padding);
  void Move(std::size_t from, std::size_t to);

  std::size_t capacity_;
  std::size_t end_ = 0;  // one past the last slot in use
  std::size_t alive_ = 0;
  std::vector<ReferenceFrame> references_;
  std::vector<std::vector<std::byte>> storage_;
  SeedColumns columns_;
};

}  // namespace livemvs
