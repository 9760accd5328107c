#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "livemvs/core/point.h"
#include "livemvs/map/map_storage.h"

namespace livemvs {

struct PointMapOptions {
  /// Width of the cells of level 0 [scene]; 0: half the median footprint of the first points.
  float spacing = 0;
  /// Width of a point's cell in footprints: how finely the map keeps a surface. The default is how
  /// far apart seeds are planted. [px]
  float cell_px = 2;
  /// Memory it may use [bytes]. When it is full, the finest points become one level coarser.
  std::size_t max_bytes = std::size_t{2} << 30;

  void Check() const;  ///< @throws std::invalid_argument naming the field.
};

/// What a point did to the map.
enum class MapChange : std::uint8_t {
  kAdded,     ///< A new point.
  kRefined,   ///< Merged into one that stood for the same piece of surface.
  kReplaced,  ///< Took the place, and the id, of a coarser one.
  kDropped,   ///< Not kept: not finite, out of the map's reach, or the back of a point that is more
              ///< certain and no cell away.
};

/// A point as the map knows it.
struct MapEntry {
  static constexpr std::uint32_t kNoId = std::numeric_limits<std::uint32_t>::max();
  Point point;
  std::uint32_t id = kNoId;       ///< Stays while the point lives; numbered from 0.
  std::uint32_t frame = 0;        ///< In which it was last seen.
  std::uint8_t observations = 0;  ///< Points that were merged into it; saturates at 255.
};

struct MapUpdate {
  MapChange change = MapChange::kDropped;
  MapEntry entry;  ///< The map's point afterwards; without an id where the point was dropped.
};

/// The points of a scene without duplicates: a surface that is seen again refines its points
/// instead of adding new ones ([VH11] Sec. 4 keeps its points in an octree).
///
/// An octree whose leaves are blocks of 8³ cells, found by their key instead of from the root. A
/// point lies at the level whose cells are as wide as its footprint (and its sigma) ask for, so
/// that near surfaces are kept finely and far ones coarsely; a cell holds one point. Merged
/// positions, normals, colours and inlier ratios are means weighted by 1 / sigma²; the sigma that
/// results is that of independent measurements, and does not know of errors they share (poses,
/// calibration).
///
/// Points with the same order of insertion give the same map. Not thread-safe.
class PointMap {
 public:
  static constexpr int kLevels = 16;

  using Entry = MapEntry;

  /// A place in the grid of a level.
  struct Cell {
    int level;
    Eigen::Vector3i at;  ///< In cells of that level.
  };

  explicit PointMap(const PointMapOptions& options = {});

  /// Adds points that were seen in `frame`.
  /// @param updates  If given, resized to one entry a point.
  void Insert(std::span<const Point> points,
              std::uint32_t frame,
              std::vector<MapUpdate>* updates = nullptr);

  std::size_t size() const { return size_; }
  std::size_t bytes() const;
  /// Width of the cells of level 0 [scene]; 0 before the first point.
  float spacing() const { return spacing_; }
  /// How often the memory was full: ids may have gone then.
  int coarsenings() const { return coarsest_floor_; }

  /// Whether a surface at `position`, seen along the unit direction `to_camera`, is already kept
  /// at about this footprint or finer, from a view whose direction differs by less than the angle
  /// of `min_cosine`.
  bool Covers(const Eigen::Vector3f& position,
              float footprint,
              const Eigen::Vector3f& to_camera,
              float min_cosine) const;

  /// Calls `visit` for every point, block by block.
  void Visit(const std::function<void(const Entry&)>& visit) const;
  PointCloud Cloud() const;

  /// A thinned cloud: at most one point in each cell of the level whose cells are as wide as
  /// `width`, or as nearly as there is a level; the one with the least sigma of those that a block
  /// holds there.
  /// @param width  [scene], > 0.
  PointCloud LevelOfDetail(float width) const;

 private:
  float Width(int level) const { return widths_[level]; }
  void ChooseSpacing(std::span<const Point> points);
  int LevelOf(float footprint, float sigma) const;
  bool CellOf(const Eigen::Vector3f& position, int level, Cell* cell) const;
  const MapBlock* FindBlock(const Cell& cell) const;
  MapBlock* BlockFor(const Cell& cell);
  StoredPoint* OccupantOf(const Cell& cell) const;
  template <typename F>
  void VisitOctant(const Cell& cell, const Eigen::Vector3f& position, F&& f) const;
  template <typename F>
  void VisitAlongRay(const Cell& cell, const StoredPoint& stored, F&& f) const;
  template <typename F>
  void VisitFiner(const Cell& cell, F&& f) const;

  struct Outcome {
    std::uint32_t id;
    MapChange change;
    const StoredPoint* at;
  };
  Outcome InsertOne(const Point& point, std::uint32_t frame);
  Outcome InsertStored(const StoredPoint& stored, const Cell& cell);
  StoredPoint* FindSame(const Cell& cell, const StoredPoint& stored, bool* opposed) const;
  bool RemoveCoarser(const Cell& cell, const StoredPoint& stored, std::uint32_t* id);
  StoredPoint Store(const Point& point, std::uint32_t frame, int level) const;
  Entry Load(const StoredPoint& stored) const;
  void Merge(const StoredPoint& stored, StoredPoint* into) const;
  void Coarsen();

  PointMapOptions options_;
  float spacing_ = 0;
  float widths_[kLevels] = {};
  int coarsest_floor_ = 0;                  // levels below it are no longer used
  std::size_t arena_after_coarsening_ = 0;  // [bytes]
  PointArena arena_;
  std::vector<MapBlock> blocks_;
  BlockTable table_;
  std::size_t level_points_[kLevels] = {};
  std::size_t size_ = 0;
  std::uint32_t next_id_ = 0;
};

}  // namespace livemvs
