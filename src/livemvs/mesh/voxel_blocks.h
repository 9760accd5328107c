#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace livemvs {

using Voxel = Eigen::Vector3i;

/// Which blocks of 4 x 4 x 4 voxels of an endless grid are there. Blocks are numbered in the order
/// of their keys; a voxel's number is 64 times its block's, and its place in the block.
class VoxelBlocks {
 public:
  static constexpr int kSide = 4;
  static constexpr int kVoxels = kSide * kSide * kSide;
  /// Blocks lie in [0, kMostBlocks) along each axis.
  static constexpr int kMostBlocks = 1 << 20;
  static constexpr std::int32_t kNone = -1;

  using Key = std::uint64_t;
  static Key KeyOf(const Eigen::Vector3i& block) {
    return static_cast<Key>(block.z()) << 42 | static_cast<Key>(block.y()) << 21 |
           static_cast<Key>(block.x());
  }
  static Eigen::Vector3i BlockOf(Key key) {
    constexpr Key kMask = (1 << 21) - 1;
    return {static_cast<int>(key & kMask),
            static_cast<int>(key >> 21 & kMask),
            static_cast<int>(key >> 42 & kMask)};
  }

  VoxelBlocks() = default;
  /// @param keys  In any order, repeated or not.
  explicit VoxelBlocks(std::vector<Key> keys);

  std::size_t blocks() const { return keys_.size(); }
  std::size_t voxels() const { return keys_.size() * kVoxels; }
  Eigen::Vector3i Block(std::size_t i) const { return BlockOf(keys_[i]); }

  /// The block's number, or kNone; also outside of the range.
  std::int32_t FindBlock(const Eigen::Vector3i& block) const;

  /// The voxel's number, or kNone.
  std::int64_t Find(const Voxel& voxel) const {
    if (voxel.minCoeff() < 0) return kNone;
    const std::int32_t block = FindBlock({voxel.x() / kSide, voxel.y() / kSide, voxel.z() / kSide});
    return block == kNone ? kNone : std::int64_t{block} * kVoxels + PlaceOf(voxel);
  }

  Voxel VoxelAt(std::int64_t number) const {
    const Eigen::Vector3i block = Block(static_cast<std::size_t>(number / kVoxels));
    const int place = static_cast<int>(number % kVoxels);
    return kSide * block + Voxel(place % kSide, place / kSide % kSide, place / (kSide * kSide));
  }

  static int PlaceOf(const Voxel& voxel) {
    return (voxel.z() % kSide * kSide + voxel.y() % kSide) * kSide + voxel.x() % kSide;
  }

 private:
  std::vector<Key> keys_;            // ascending
  std::vector<std::int32_t> table_;  // open addressing, a power of 2 entries
  std::uint64_t mask_ = 0;
};

/// Finds voxels next to each other without looking each one up. Not thread-safe: one per thread.
class VoxelCursor {
 public:
  explicit VoxelCursor(const VoxelBlocks& blocks) : blocks_(&blocks) {}

  /// As VoxelBlocks::Find(), fast where the block is that of one of the last calls.
  std::int64_t Find(const Voxel& voxel) {
    if (voxel.minCoeff() < 0) return VoxelBlocks::kNone;
    const Eigen::Vector3i block(voxel.x() / VoxelBlocks::kSide,
                                voxel.y() / VoxelBlocks::kSide,
                                voxel.z() / VoxelBlocks::kSide);
    Entry& entry = entries_[static_cast<std::size_t>((block.x() & 3) | (block.y() & 3) << 2 |
                                                     (block.z() & 3) << 4)];
    if (entry.block != block) entry = {block, blocks_->FindBlock(block)};
    if (entry.number == VoxelBlocks::kNone) return VoxelBlocks::kNone;
    return std::int64_t{entry.number} * VoxelBlocks::kVoxels + VoxelBlocks::PlaceOf(voxel);
  }

 private:
  struct Entry {
    Eigen::Vector3i block{-1, -1, -1};
    std::int32_t number = VoxelBlocks::kNone;
  };
  const VoxelBlocks* blocks_;
  std::array<Entry, 64> entries_{};
};

}  // namespace livemvs
