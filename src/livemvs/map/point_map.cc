#include "livemvs/map/point_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace livemvs {
namespace {

constexpr int kBlockShift = MapBlock::kSideLog2;
constexpr int kCellMask = MapBlock::kSide - 1;

// Cells farther out than this have no key.
constexpr float kMostCells = static_cast<float>((BlockKey::kOffset - 1) * MapBlock::kSide);

// Levels above and below a point's own in which the same surface is looked for: footprints of
// one surface seen from different distances.
constexpr int kReach = 2;

// A cell is at least this many sigmas wide ...
constexpr float kSigmasInCell = 2;

// ... and a point is also looked for this many sigmas before and behind, along the ray that
// measured it: that is where noise puts it.
constexpr float kSigmasAlongRay = 2.5F;

// A point of a neighbouring cell stands for a new one nearer than this many cells: a surface that
// only clips a cell's corner is its neighbour's.
constexpr float kMergeCells = 1.2F;

// A point is the back of another where their directions differ by more than about 100°.
constexpr float kOpposed = -0.2F;

// A point whose footprint was this many times as wide as asked for does not cover, as in MarkPoint.
constexpr float kCoarser = 1.5F;

std::uint64_t KeyOf(const PointMap::Cell& cell) {
  return BlockKey{
      cell.level,
      {cell.at.x() >> kBlockShift, cell.at.y() >> kBlockShift, cell.at.z() >> kBlockShift}}
      .Pack();
}

bool Opposed(const StoredPoint& a, const StoredPoint& b) {
  if (a.normal[0] == b.normal[0] && a.normal[1] == b.normal[1]) return false;
  return DecodeNormal(a.normal).dot(DecodeNormal(b.normal)) < kOpposed;
}

}  // namespace

void PointMapOptions::Check() const {
  if (!(spacing >= 0) || !std::isfinite(spacing)) {
    throw std::invalid_argument("PointMap: spacing must be 0 or more");
  }
  if (!(cell_px > 0) || !std::isfinite(cell_px)) {
    throw std::invalid_argument("PointMap: cell_px must be above 0");
  }
  constexpr std::size_t kLeast = std::size_t{4} << 20;
  if (max_bytes < kLeast) throw std::invalid_argument("PointMap: max_bytes must be 4 MiB or more");
}

PointMap::PointMap(const PointMapOptions& options) : options_(options) {
  options_.Check();
  if (options_.spacing > 0) spacing_ = options_.spacing;
  for (int level = 0; level < kLevels; ++level) widths_[level] = std::ldexp(spacing_, level);
}

void PointMap::Insert(std::span<const Point> points,
                      std::uint32_t frame,
                      std::vector<MapUpdate>* updates) {
  if (updates != nullptr) updates->clear();
  if (spacing_ == 0) ChooseSpacing(points);
  for (const Point& point : points) {
    const Outcome outcome = InsertOne(point, frame);
    if (updates != nullptr) {
      updates->push_back({outcome.change, outcome.at != nullptr ? Load(*outcome.at) : Entry{}});
    }
    // What a coarsening freed is used up before the memory grows again.
    if (arena_.bytes() > arena_after_coarsening_ && bytes() > options_.max_bytes &&
        coarsest_floor_ + 1 < kLevels) {
      Coarsen();
    }
  }
}

void PointMap::ChooseSpacing(std::span<const Point> points) {
  std::vector<float> footprints;
  for (const Point& point : points) {
    const float width = point.footprint > 0 ? point.footprint : point.sigma;
    if (width > 0 && std::isfinite(width)) footprints.push_back(width);
  }
  if (footprints.empty()) {
    if (points.empty()) return;
    footprints.push_back(1);
  }
  const auto middle = footprints.begin() + static_cast<std::ptrdiff_t>(footprints.size() / 2);
  std::nth_element(footprints.begin(), middle, footprints.end());
  spacing_ = std::clamp(*middle * options_.cell_px / 4, 1e-30F, 1e30F);
  for (int level = 0; level < kLevels; ++level) widths_[level] = std::ldexp(spacing_, level);
}

int PointMap::LevelOf(float footprint, float sigma) const {
  const float wanted = std::max(footprint * options_.cell_px, kSigmasInCell * sigma);
  const float ratio = wanted / spacing_;
  if (!(ratio > 1)) return coarsest_floor_;
  // The cell is as wide as wanted within a factor of sqrt(2).
  const int level = std::ilogb(ratio * static_cast<float>(M_SQRT2));
  return std::clamp(level, coarsest_floor_, kLevels - 1);
}

bool PointMap::CellOf(const Eigen::Vector3f& position, int level, Cell* cell) const {
  const Eigen::Vector3f scaled = position / Width(level);
  if (!scaled.allFinite() || scaled.lpNorm<Eigen::Infinity>() >= kMostCells) return false;
  cell->level = level;
  for (int k = 0; k < 3; ++k) {
    const int truncated = static_cast<int>(scaled[k]);
    cell->at[k] = truncated - (static_cast<float>(truncated) > scaled[k] ? 1 : 0);
  }
  return true;
}

const MapBlock* PointMap::FindBlock(const Cell& cell) const {
  const std::uint32_t found = table_.Find(KeyOf(cell));
  return found != BlockTable::kNone ? &blocks_[found] : nullptr;
}

MapBlock* PointMap::BlockFor(const Cell& cell) {
  if (const MapBlock* block = FindBlock(cell)) return const_cast<MapBlock*>(block);
  const std::uint64_t key = KeyOf(cell);
  blocks_.push_back({.key = key});
  table_.Insert(key, static_cast<std::uint32_t>(blocks_.size() - 1));
  return &blocks_.back();
}

StoredPoint* PointMap::OccupantOf(const Cell& cell) const {
  const MapBlock* block = FindBlock(cell);
  if (block == nullptr) return nullptr;
  return block->At(cell.at.x() & kCellMask, cell.at.y() & kCellMask, cell.at.z() & kCellMask);
}

// The occupants of the 7 cells that meet the position's own at the corner nearest to it.
template <typename F>
void PointMap::VisitOctant(const Cell& cell, const Eigen::Vector3f& position, F&& f) const {
  const Eigen::Vector3f inside = position / Width(cell.level) - cell.at.cast<float>();
  const Eigen::Vector3i side(
      (inside.x() < 0.5F) ? -1 : 1, (inside.y() < 0.5F) ? -1 : 1, (inside.z() < 0.5F) ? -1 : 1);
  // All are fetched from memory at once, before any is looked at.
  std::array<StoredPoint*, 7> occupants;
  std::size_t count = 0;
  for (int corner = 1; corner < 8; ++corner) {
    const Eigen::Vector3i step(
        corner & 1 ? side.x() : 0, corner & 2 ? side.y() : 0, corner & 4 ? side.z() : 0);
    occupants[count] = OccupantOf({cell.level, cell.at + step});
    if (occupants[count] != nullptr) __builtin_prefetch(occupants[count++]);
  }
  for (std::size_t i = 0; i < count; ++i) f(occupants[i]);
}

// The occupants of the cells that the point's ray passes within its uncertainty.
template <typename F>
void PointMap::VisitAlongRay(const Cell& cell, const StoredPoint& stored, F&& f) const {
  const float width = Width(cell.level);
  const float reach = kSigmasAlongRay / std::sqrt(stored.weight);
  const Eigen::Vector3f ray = DecodeNormal(stored.normal);
  // Few, because cells are as wide as their points are uncertain; but for points that are more so
  // than the widest cell.
  constexpr int kMostSteps = 32;
  for (int i = 1; i <= kMostSteps; ++i) {
    const float along = static_cast<float>(i) * width;
    if (!(along < reach + width)) break;
    for (const float signed_along : {along, -along}) {
      Cell other;
      const float step = std::clamp(signed_along, -reach, reach);
      if (!CellOf(stored.position + step * ray, cell.level, &other)) continue;
      if (other.at == cell.at) continue;
      if (StoredPoint* occupant = OccupantOf(other)) f(occupant);
    }
  }
}

// The points of finer levels that lie in the cell.
template <typename F>
void PointMap::VisitFiner(const Cell& cell, F&& f) const {
  for (int down = 1; down <= kReach && cell.level - down >= coarsest_floor_; ++down) {
    if (level_points_[cell.level - down] == 0) continue;
    const Eigen::Vector3i first = cell.at * (1 << down);
    if (first.cwiseAbs().maxCoeff() >= static_cast<int>(kMostCells)) continue;
    const MapBlock* block = FindBlock({cell.level - down, first});
    if (block == nullptr) continue;
    const int x = first.x() & kCellMask, y = first.y() & kCellMask, z = first.z() & kCellMask;
    const int side = 1 << down;
    std::uint64_t rows = 0;
    for (int v = 0; v < side; ++v) {
      rows |= ((std::uint64_t{1} << side) - 1) << (MapBlock::kSide * (y + v) + x);
    }
    for (int w = z; w < z + side; ++w) {
      for (std::uint64_t left = block->mask[w] & rows; left != 0; left &= left - 1) {
        f(block->points + block->Rank(w, left & ~(left - 1)));
      }
    }
  }
}

PointMap::Outcome PointMap::InsertOne(const Point& point, std::uint32_t frame) {
  const int level = LevelOf(point.footprint, point.sigma);
  Cell cell;
  if (spacing_ == 0 || !CellOf(point.position, level, &cell)) {
    return {MapEntry::kNoId, MapChange::kDropped, nullptr};
  }
  return InsertStored(Store(point, frame, level), cell);
}

PointMap::Outcome PointMap::InsertStored(const StoredPoint& stored, const Cell& cell) {
  bool opposed = false;
  if (StoredPoint* same = FindSame(cell, stored, &opposed)) {
    if (opposed) {
      // One cell cannot hold both faces of a sheet: the more certain one stays.
      if (!(stored.weight > same->weight)) return {MapEntry::kNoId, MapChange::kDropped, nullptr};
      const std::uint32_t id = same->id;
      *same = stored;
      same->id = id;
      return {id, MapChange::kReplaced, same};
    }
    Merge(stored, same);
    return {same->id, MapChange::kRefined, same};
  }
  StoredPoint added = stored;
  std::uint32_t id = stored.id;
  const bool replaces = RemoveCoarser(cell, stored, &id);
  if (!replaces && id == MapEntry::kNoId) id = next_id_++;
  added.id = id;
  MapBlock* block = BlockFor(cell);
  const StoredPoint* at = block->Add(
      cell.at.x() & kCellMask, cell.at.y() & kCellMask, cell.at.z() & kCellMask, added, &arena_);
  ++level_points_[cell.level];
  ++size_;
  return {id, replaces ? MapChange::kReplaced : MapChange::kAdded, at};
}

// The point that stands for the same piece of surface: of the same cell, of a neighbouring one
// near enough, or a finer one in the cell.
StoredPoint* PointMap::FindSame(const Cell& cell, const StoredPoint& stored, bool* opposed) const {
  if (StoredPoint* occupant = OccupantOf(cell)) {
    *opposed = Opposed(*occupant, stored);
    return occupant;
  }
  const float reach = kMergeCells * Width(cell.level);
  StoredPoint* nearest = nullptr;
  float least = reach * reach;
  const auto keep_nearest = [&](StoredPoint* other) {
    const float distance2 = (other->position - stored.position).squaredNorm();
    if (distance2 < least && !Opposed(*other, stored)) {
      least = distance2;
      nearest = other;
    }
  };
  VisitOctant(cell, stored.position, keep_nearest);
  if (nearest != nullptr) return nearest;
  least = std::numeric_limits<float>::max();
  VisitAlongRay(cell, stored, keep_nearest);
  if (nearest != nullptr) return nearest;
  VisitFiner(cell, keep_nearest);
  return nearest;
}

// Takes out a coarser point in whose cell the new one lies; its id goes to the new one.
bool PointMap::RemoveCoarser(const Cell& cell, const StoredPoint& stored, std::uint32_t* id) {
  for (int up = 1; up <= kReach && cell.level + up < kLevels; ++up) {
    if (level_points_[cell.level + up] == 0) continue;
    const Cell coarse = {cell.level + up,
                         {cell.at.x() >> up, cell.at.y() >> up, cell.at.z() >> up}};
    const StoredPoint* occupant = OccupantOf(coarse);
    if (occupant == nullptr || Opposed(*occupant, stored)) continue;
    if (*id == MapEntry::kNoId) *id = occupant->id;
    const_cast<MapBlock*>(FindBlock(coarse))
        ->Remove(coarse.at.x() & kCellMask, coarse.at.y() & kCellMask, coarse.at.z() & kCellMask);
    --level_points_[coarse.level];
    --size_;
    return true;
  }
  return false;
}

bool PointMap::Covers(const Eigen::Vector3f& position,
                      float footprint,
                      const Eigen::Vector3f& to_camera,
                      float min_cosine) const {
  Cell cell;
  const int level = LevelOf(footprint, 0);
  if (spacing_ == 0 || !CellOf(position, level, &cell)) return false;
  bool covered = false;
  const auto look = [&](const StoredPoint* other) {
    const float other_footprint = DecodeFootprint(other->footprint, spacing_);
    covered = covered || (other_footprint <= kCoarser * footprint &&
                          DecodeNormal(other->normal).dot(to_camera) > min_cosine);
  };
  if (const StoredPoint* occupant = OccupantOf(cell)) look(occupant);
  const float reach = kMergeCells * Width(level);
  VisitOctant(cell, position, [&](const StoredPoint* other) {
    if ((other->position - position).squaredNorm() < reach * reach) look(other);
  });
  // Finer points cover whatever their footprint.
  VisitFiner(cell, [&](const StoredPoint* other) {
    covered = covered || DecodeNormal(other->normal).dot(to_camera) > min_cosine;
  });
  return covered;
}

}  // namespace livemvs
