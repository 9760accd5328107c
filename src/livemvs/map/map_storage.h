#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace livemvs {

/// A point as the map keeps it. 36 bytes.
struct StoredPoint {
  Eigen::Vector3f position;            ///< In the world [scene].
  float weight;                        ///< Sum of 1 / sigma² of what was merged [scene^-2].
  std::array<std::int16_t, 2> normal;  ///< Octahedral, as EncodeNormal().
  std::array<std::uint8_t, 3> color;
  std::uint8_t inlier_ratio;  ///< In 255ths.
  std::uint16_t views;        ///< Saturates.
  std::uint8_t observations;  ///< Points that were merged into it; saturates.
  std::uint8_t footprint;     ///< As EncodeFootprint().
  std::uint32_t frame;        ///< In which it was last seen.
  std::uint32_t id;
};
static_assert(sizeof(StoredPoint) == 36);

/// A unit vector folded onto the octahedron: two coordinates in [-1, 1] as 16-bit fractions.
/// Error below 0.003°. A zero vector becomes +z.
std::array<std::int16_t, 2> EncodeNormal(const Eigen::Vector3f& normal);
Eigen::Vector3f DecodeNormal(const std::array<std::int16_t, 2>& code);

/// Width of a pixel on the surface in 14ths of an octave, from half the map's spacing to 2^17 times
/// it; 0: none is known. Error below 2.6 %.
std::uint8_t EncodeFootprint(float footprint, float spacing);
float DecodeFootprint(std::uint8_t code, float spacing);

/// Level and number of a block as one word: 4 bits and 3 x 20 bits.
struct BlockKey {
  static constexpr int kBits = 20;
  static constexpr int kOffset = 1 << (kBits - 1);  ///< Blocks count from -kOffset to kOffset - 1.

  int level;
  Eigen::Vector3i at;

  std::uint64_t Pack() const {
    std::uint64_t key = static_cast<std::uint64_t>(level);
    for (int k = 0; k < 3; ++k) key = (key << kBits) | static_cast<std::uint64_t>(at[k] + kOffset);
    return key;
  }
  static BlockKey Unpack(std::uint64_t key) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
    return {static_cast<int>(key >> (3 * kBits)),
            {static_cast<int>((key >> (2 * kBits)) & kMask) - kOffset,
             static_cast<int>((key >> kBits) & kMask) - kOffset,
             static_cast<int>(key & kMask) - kOffset}};
  }
};

/// Memory for the points of blocks, in a few sizes, taken from the system in large pieces and never
/// given back before the end; what one block outgrows serves the next.
class PointArena {
 public:
  static constexpr std::array<std::uint16_t, 13> kCapacities = {
      8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512};

  /// Room for at least `count` points, at most 512; `capacity` is set to how many fit.
  StoredPoint* Allocate(std::size_t count, std::uint16_t* capacity);
  void Free(StoredPoint* points, std::uint16_t capacity);
  /// From now on larger pieces that are free are used up before new memory is asked for.
  void BeThrifty() { thrifty_ = true; }
  std::size_t bytes() const { return chunks_.size() * kChunkBytes; }

 private:
  static constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
  static constexpr std::size_t kChunkPoints = kChunkBytes / sizeof(StoredPoint);

  std::vector<std::unique_ptr<StoredPoint[]>> chunks_;
  std::size_t used_ = kChunkPoints;  // of the last chunk
  bool thrifty_ = false;
  std::array<std::vector<StoredPoint*>, kCapacities.size()> free_;
};

/// 8 x 8 x 8 cells of one level, each empty or with one point. A leaf of the octree.
struct MapBlock {
  static constexpr int kSideLog2 = 3;
  static constexpr int kSide = 1 << kSideLog2;

  std::uint64_t key = 0;
  std::array<std::uint64_t, kSide> mask{};    ///< Occupied cells: word z, bit 8 y + x.
  std::array<std::uint16_t, kSide> before{};  ///< Points in the words before.
  StoredPoint* points = nullptr;              ///< In the order of the bits.
  std::uint16_t count = 0;
  std::uint16_t capacity = 0;

  /// The point of a cell, coordinates 0 ... 7, or nullptr.
  StoredPoint* At(int x, int y, int z) const {
    const std::uint64_t bit = std::uint64_t{1} << (kSide * y + x);
    return mask[z] & bit ? points + Rank(z, bit) : nullptr;
  }
  /// Points before a cell.
  std::size_t Rank(int z, std::uint64_t bit) const {
    return before[z] + static_cast<std::size_t>(std::popcount(mask[z] & (bit - 1)));
  }
  /// The cell must be empty.
  const StoredPoint* Add(int x, int y, int z, const StoredPoint& point, PointArena* arena);
  void Remove(int x, int y, int z);
  /// Gives its memory back and leaves it empty.
  void Clear(PointArena* arena);
};

/// From keys to numbers of blocks: open addressing, at most half full. What was last looked for, as
/// a rule near what comes next, is kept apart from the large table. Not thread-safe.
class BlockTable {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t Find(std::uint64_t key) const {
    Entry& recent = recent_[Hash(key) % kRecent];
    if (recent.key != key) recent = {key, Search(key)};
    return recent.block;
  }
  /// The key must not be there yet.
  void Insert(std::uint64_t key, std::uint32_t block);
  void Clear();
  std::size_t bytes() const { return entries_.size() * sizeof(Entry); }

 private:
  static constexpr std::size_t kRecent = 1024;
  struct Entry {
    std::uint64_t key = ~std::uint64_t{0};  // of no block
    std::uint32_t block = kNone;
  };
  static std::size_t Hash(std::uint64_t key) {
    key *= 0x9E3779B97F4A7C15U;
    return static_cast<std::size_t>(key ^ (key >> 32));
  }
  std::uint32_t Search(std::uint64_t key) const;
  void Place(const Entry& entry);
  void Grow();

  std::vector<Entry> entries_;
  std::size_t used_ = 0;
  mutable std::array<Entry, kRecent> recent_;
};

}  // namespace livemvs
