#include "livemvs/mesh/voxel_blocks.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

std::uint64_t Hash(std::uint64_t key) {  // the finaliser of SplitMix64
  key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ key >> 27) * 0x94d049bb133111ebULL;
  return key ^ key >> 31;
}

}  // namespace

VoxelBlocks::VoxelBlocks(std::vector<Key> keys) : keys_(std::move(keys)) {
  std::ranges::sort(keys_);
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  keys_.shrink_to_fit();
  if (keys_.size() > std::numeric_limits<std::int32_t>::max() / 4) {
    throw Error(ErrorKind::kOutOfResource, "the grid is too large; choose larger voxels");
  }
  table_.assign(std::bit_ceil(2 * keys_.size() + 1), kNone);
  mask_ = table_.size() - 1;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    std::uint64_t at = Hash(keys_[i]) & mask_;
    while (table_[at] != kNone) at = (at + 1) & mask_;
    table_[at] = static_cast<std::int32_t>(i);
  }
}

std::int32_t VoxelBlocks::FindBlock(const Eigen::Vector3i& block) const {
  if (table_.empty() || block.minCoeff() < 0 || block.maxCoeff() >= kMostBlocks) return kNone;
  const Key key = KeyOf(block);
  for (std::uint64_t at = Hash(key) & mask_; table_[at] != kNone; at = (at + 1) & mask_) {
    if (keys_[static_cast<std::size_t>(table_[at])] == key) return table_[at];
  }
  return kNone;
}

}  // namespace livemvs
