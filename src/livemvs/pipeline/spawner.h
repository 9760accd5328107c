#pragma once

#include <cstdint>
#include <span>
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

  /// Adds a group of seeds to the pool for each level of the frame's pyramid, and returns how many
  /// seeds in all.
  std::int64_t Spawn(const PosedFrame& frame,
                     std::span<const ImageView<std::uint8_t>> pyramid,
                     const PointCloud& points,
                     SeedPool* pool);

 private:
  /// The frame at one level of its pyramid.
  struct View {
    int level;
    ImageView<std::uint8_t> grey;
    Camera camera;
    Rigid3d cam_from_world;
    std::int64_t frame_index;
  };
  /// What is kept of each level between frames.
  struct Maps {
    Image<std::uint8_t> covered;    // 1 where no seed is wanted
    Image<std::uint8_t> candidate;  // 1 + phase of the thinning pattern where a seed may be planted
  };

  void CoverBySeeds(const View& view, const SeedPool& pool, Maps* maps) const;
  void CoverByPoints(const View& view, const PointCloud& points, Maps* maps) const;
  void FindCandidates(const View& view, Maps* maps) const;
  void Stamp(float x, float y, Image<std::uint8_t>* covered) const;
  std::int64_t Plant(const View& view, const Maps& maps, std::size_t slots, SeedPool* pool) const;
  bool PlantOne(const View& view, const Projector& projector, int x, int y, SeedPool* pool) const;

  Options options_;
  SceneRange range_;
  std::vector<Maps> maps_;  // by level
};

}  // namespace livemvs
