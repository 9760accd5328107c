#pragma once

#include "livemvs/core/seed_record.h"

namespace livemvs {

/// Learns what became of each seed. Called in the order of the pool, never from two threads at
/// once, though not always from the thread that called the Reconstructor. An exception leaves
/// AddFrame(); the reconstruction then keeps its points, but must not go on.
class SeedObserver {
 public:
  virtual ~SeedObserver() = default;

  /// A seed ended in this frame, or was reported alive at the end of the run.
  virtual void OnSeed(const SeedRecord& /*record*/) {}
};

}  // namespace livemvs
