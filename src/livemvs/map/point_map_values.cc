// PointMap: values of its points, what is asked of it, and what is done when its memory is full.
#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "livemvs/map/point_map.h"

namespace livemvs {
namespace {

// A sigma below this share of the footprint is not believed: the pixel's own error remains.
constexpr float kLeastSigma = 0.01F;

template <typename T>
T SaturatingAdd(T a, T b) {
  return static_cast<T>(
      std::min<unsigned>(unsigned{a} + unsigned{b}, std::numeric_limits<T>::max()));
}

// Moves a mean of bytes.
std::uint8_t Blend(std::uint8_t mean, std::uint8_t value, float share) {
  const float m = mean;
  return static_cast<std::uint8_t>(m + share * (static_cast<float>(value) - m) + 0.5F);
}

}  // namespace

// Means weighted by 1 / sigma².
void PointMap::Merge(const StoredPoint& stored, StoredPoint* into) const {
  const float total = into->weight + stored.weight;
  const float share = stored.weight / total;
  into->position += share * (stored.position - into->position);
  if (into->normal != stored.normal) {
    const Eigen::Vector3f a = DecodeNormal(into->normal), b = DecodeNormal(stored.normal);
    into->normal = EncodeNormal(a + share * (b - a));
  }
  for (int k = 0; k < 3; ++k) into->color[k] = Blend(into->color[k], stored.color[k], share);
  into->inlier_ratio = Blend(into->inlier_ratio, stored.inlier_ratio, share);
  into->weight = std::min(total, 1e30F);
  into->views = SaturatingAdd(into->views, stored.views);
  into->observations = SaturatingAdd(into->observations, stored.observations);
  into->frame = std::max(into->frame, stored.frame);
}

StoredPoint PointMap::Store(const Point& point, std::uint32_t frame, int level) const {
  StoredPoint stored;
  stored.position = point.position;
  const float width = Width(level);
  const float scale =
      point.footprint > 0 && std::isfinite(point.footprint) ? point.footprint : width;
  const float sigma = point.sigma > 0 && std::isfinite(point.sigma) ? point.sigma : scale / 2;
  // Within what a weight can be the inverse square of.
  constexpr float kLeast = 1e-15F, kMost = 1e15F;
  const float uncertainty = std::clamp(std::max(sigma, kLeastSigma * scale), kLeast, kMost);
  stored.weight = 1 / (uncertainty * uncertainty);
  stored.normal = EncodeNormal(point.normal);
  stored.color = point.color;
  const float ratio = std::isfinite(point.inlier_ratio) ? point.inlier_ratio : 0;
  stored.inlier_ratio = static_cast<std::uint8_t>(255 * std::clamp(ratio, 0.0F, 1.0F) + 0.5F);
  stored.views = point.views;
  stored.observations = 1;
  stored.footprint = EncodeFootprint(point.footprint, spacing_);
  stored.frame = frame;
  stored.id = MapEntry::kNoId;
  return stored;
}

PointMap::Entry PointMap::Load(const StoredPoint& stored) const {
  Entry entry;
  entry.point.position = stored.position;
  entry.point.normal = DecodeNormal(stored.normal);
  entry.point.color = stored.color;
  entry.point.sigma = 1 / std::sqrt(stored.weight);
  entry.point.inlier_ratio = static_cast<float>(stored.inlier_ratio) / 255;
  entry.point.views = stored.views;
  entry.point.footprint = DecodeFootprint(stored.footprint, spacing_);
  entry.id = stored.id;
  entry.frame = stored.frame;
  entry.observations = stored.observations;
  return entry;
}

std::size_t PointMap::bytes() const {
  return arena_.bytes() + blocks_.capacity() * sizeof(MapBlock) + table_.bytes();
}

void PointMap::Visit(const std::function<void(const Entry&)>& visit) const {
  for (const MapBlock& block : blocks_) {
    for (int i = 0; i < block.count; ++i) visit(Load(block.points[i]));
  }
}

PointCloud PointMap::Cloud() const {
  PointCloud cloud;
  cloud.reserve(size_);
  Visit([&](const Entry& entry) { cloud.push_back(entry.point); });
  return cloud;
}

PointCloud PointMap::LevelOfDetail(float width) const {
  PointCloud cloud;
  if (spacing_ == 0) return cloud;
  const int wanted =
      std::clamp(std::ilogb(std::max(width / spacing_, 1.0F) * static_cast<float>(M_SQRT2)),
                 coarsest_floor_,
                 kLevels - 1);
  // Of the cells of the wanted level that several blocks share, the first block's point is taken.
  std::unordered_set<std::uint64_t> taken;
  for (const MapBlock& block : blocks_) {
    const BlockKey key = BlockKey::Unpack(block.key);
    const int down = wanted - key.level;
    const int shift = std::clamp(down, 0, MapBlock::kSideLog2);
    // The most certain point of each cube of 2^shift cells; all where shift is 0.
    std::array<const StoredPoint*, 512> best{};
    const StoredPoint* point = block.points;
    for (int z = 0; z < MapBlock::kSide; ++z) {
      for (std::uint64_t left = block.mask[z]; left != 0; left &= left - 1, ++point) {
        const int bit = std::countr_zero(left);
        const int cube = ((((z >> shift) << 3) | (bit >> 3 >> shift)) << 3) | ((bit & 7) >> shift);
        if (best[cube] == nullptr || best[cube]->weight < point->weight) best[cube] = point;
      }
    }
    if (down > MapBlock::kSideLog2) {
      const int up = down - MapBlock::kSideLog2;
      const Eigen::Vector3i cell(key.at.x() >> up, key.at.y() >> up, key.at.z() >> up);
      if (block.count == 0 || !taken.insert(BlockKey{wanted, cell}.Pack()).second) continue;
    }
    for (const StoredPoint* kept : best) {
      if (kept != nullptr) cloud.push_back(Load(*kept).point);
    }
  }
  return cloud;
}

void PointMap::Coarsen() {
  ++coarsest_floor_;
  arena_.BeThrifty();
  const std::size_t old_blocks = blocks_.size();
  std::vector<StoredPoint> moving;
  for (std::size_t b = 0; b < old_blocks; ++b) {
    const int level = BlockKey::Unpack(blocks_[b].key).level;
    if (level >= coarsest_floor_ || blocks_[b].count == 0) continue;
    moving.assign(blocks_[b].points, blocks_[b].points + blocks_[b].count);
    level_points_[level] -= moving.size();
    size_ -= moving.size();
    blocks_[b].Clear(&arena_);
    for (const StoredPoint& stored : moving) {
      Cell cell;
      if (CellOf(stored.position, coarsest_floor_, &cell)) InsertStored(stored, cell);
    }
  }
  std::erase_if(blocks_, [](const MapBlock& block) { return block.count == 0; });
  blocks_.shrink_to_fit();
  table_.Clear();
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    table_.Insert(blocks_[b].key, static_cast<std::uint32_t>(b));
  }
  arena_after_coarsening_ = arena_.bytes();
}

}  // namespace livemvs
