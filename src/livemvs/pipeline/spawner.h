#pragma once

#include <cstdint>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/pipeline/scene_range.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

/// Pixels [x0, x1) x [y0, y1).
struct PixelRect {
  int x0, y0, x1, y1;
};

/// Step 1 of Algorithm 1: plants new seeds in a frame where a point is still missing.
///
/// A pixel gets a seed if its patch has texture, its ray crosses the scene's range, and neither a
/// live seed nor a point that was seen from a similar direction projects near it. Where there are
/// more such pixels than free slots, they are thinned evenly over the picture. Buffers are kept
/// between frames.
class Spawner {
 public:
  Spawner(const Options& options, const SceneRange& range);

  /// Adds a group of seeds to the pool and returns how many.
  std::int64_t Spawn(const PosedFrame& frame, const PointCloud& points, SeedPool* pool);

 private:
  void CoverBySeeds(const PosedFrame& frame, const SeedPool& pool);
  void CoverByPoints(const PosedFrame& frame, const PointCloud& points);
  void FindCandidates(const ImageView<std::uint8_t>& grey, const PixelRect& rect);
  void Stamp(float x, float y);
  std::int64_t Plant(const PosedFrame& frame, std::size_t slots, SeedPool* pool);
  bool PlantOne(const PosedFrame& frame, const Projector& projector, int x, int y, SeedPool* pool);

  Options options_;
  SceneRange range_;
  Image<std::uint8_t> covered_;    // 1 where no seed is wanted
  Image<std::uint8_t> candidate_;  // 1 + phase of the thinning pattern where a seed may be planted
};

}  // namespace livemvs
