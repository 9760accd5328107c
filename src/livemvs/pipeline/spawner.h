#pragma once

#include <cstdint>
#include <span>

#include "livemvs/backend/backend.h"
#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/core/scene_range.h"
#include "livemvs/pipeline/candidates.h"
#include "livemvs/pipeline/coverage.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

/// Step 1 of Algorithm 1: plants new seeds in a frame where a point is still missing.
///
/// A pixel gets a seed if its patch has texture, its ray crosses the scene's range, and neither a
/// live seed nor a point that was seen from a similar direction projects near it. Where there are
/// more such pixels than free slots, they are thinned evenly over the picture. Buffers are kept
/// between frames.
class Spawner {
 public:
  Spawner(const Options& options, const SceneRange& range);

  /// Adds a group of seeds to the pool for each level of the frame's pyramid, and returns how many
  /// seeds in all. Closes the gaps in the pool before.
  /// @param points  Those of the last call, and new ones after them; see Forget().
  std::int64_t Spawn(const PosedFrame& frame,
                     std::span<const ImageView<std::uint8_t>> pyramid,
                     const PointCloud& points,
                     SeedPool* pool);

  /// The points of the next call are others than those before.
  void Forget() { coverage_.Forget(); }

 private:
  /// The frame at one level of its pyramid.
  struct View {
    int level;
    ImageView<std::uint8_t> grey;
    Camera camera;
    Rigid3d cam_from_world;
    std::int64_t frame_index;
  };

  std::int64_t Plant(const View& view, SeedPool* pool);
  std::size_t PlantShare(const View& view,
                         std::size_t wanted,
                         SeedPool* pool,
                         std::int64_t* planted);
  bool PlantOne(const View& view, const Projector& projector, int x, int y, SeedPool* pool) const;

  Options options_;
  SceneRange range_;
  Coverage coverage_;
  Candidates candidates_;
};

}  // namespace livemvs
