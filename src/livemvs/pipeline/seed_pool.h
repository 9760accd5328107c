#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// Seeds born in the same frame at the same level of its pyramid: entries [begin, end) of the pool.
struct ReferenceFrame {
  std::size_t begin;
  std::size_t end;
  std::size_t alive;  ///< Of them.
  std::int64_t frame_index;
  int level;
  Camera camera;  ///< At that level.
  Rigid3d cam_from_world;
  Eigen::Vector3d last_met_from;  ///< Camera's centre in the last frame that the seeds met, or own.
  int left_out = 0;               ///< Frames since then.
};

/// The M seeds of Algorithm 1, grouped by reference frame in order of birth. Their state is the
/// backend's. Not thread-safe.
class SeedPool {
 public:
  /// @param backend  Has no seeds yet; those it gets are the pool's alone.
  explicit SeedPool(std::unique_ptr<Backend> backend) : backend_(std::move(backend)) {}

  /// For what is done to the seeds where they are.
  Backend& backend() const { return *backend_; }

  /// [VH11] M.
  std::size_t capacity() const { return backend_->capacity(); }
  /// Seeds alive. [VH11] S.
  std::size_t size() const { return alive_; }
  /// Of which those that removed seeds left are usable after Compact() only.
  std::size_t free_slots() const { return capacity() - alive_; }
  const std::vector<ReferenceFrame>& references() const { return references_; }

  /// Plants seeds in the backend's current frame (step 1 of Algorithm 1), as a group for each level
  /// of its pyramid, and returns how many in all.
  std::int64_t Plant(std::int64_t frame_index, const Planting& planting);

  /// Gives the reference frames whose seeds are to meet (step 2) a frame with that pose, whose
  /// pyramid has `levels` levels, and counts the frame as met by those and left out by the others:
  /// see Options::min_move.
  std::vector<ReferenceFrame> Meet(const Rigid3d& cam_from_world, int levels, double min_move);

  /// Calls f(reference, ended) for the seeds that ended, in order; their slots are free after the
  /// next Compact().
  template <typename F>
  void TakeEnded(const F& f) {
    auto reference = references_.begin();
    for (const EndedSeed& ended : backend_->TakeEnded()) {
      while (ended.slot >= reference->end) ++reference;
      --reference->alive;
      --alive_;
      f(*reference, ended);
    }
  }

  /// Closes the gaps that removed seeds left; order is kept, empty groups go.
  void Compact();

  /// Calls f(reference, seed) for every step-th of the slots whose seed is alive, in order: for
  /// looking at them.
  template <typename F>
  void ForEachAlive(std::size_t step, const F& f) const {
    for (const ReferenceFrame& reference : references_) {
      const std::size_t first = (reference.begin + step - 1) / step * step;
      if (first >= reference.end) continue;
      for (const SeedState& seed : backend_->Read(first, reference.end, step)) {
        if (seed.fate == Fate::kAlive) f(reference, seed);
      }
    }
  }

  /// The patches of a group's seeds, removed ones too, kPatchPixels each: for looking at them.
  std::vector<std::uint8_t> Patches(const ReferenceFrame& reference) const {
    return backend_->ReadPatches(reference.begin, reference.end);
  }

 private:
  std::unique_ptr<Backend> backend_;
  std::size_t end_ = 0;  // one past the last slot in use
  std::size_t alive_ = 0;
  std::vector<ReferenceFrame> references_;
};

}  // namespace livemvs
