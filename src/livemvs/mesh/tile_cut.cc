#include "livemvs/mesh/tile_cut.h"

#include <algorithm>
#include <array>
#include <vector>

#include "livemvs/mesh/min_cut.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// Side of a tile and width of the margin about it. [blocks]
constexpr int kTile = 12, kMargin = 2;
constexpr std::int32_t kAbsent = -1;

/// Blocks of [lo, hi).
struct BlockBox {
  Eigen::Vector3i lo, hi;

  bool Contains(const Eigen::Vector3i& b) const {
    return (b.array() >= lo.array()).all() && (b.array() < hi.array()).all();
  }
};

/// The graph of the voxels in a box of blocks.
class TileGraph {
 public:
  TileGraph(std::size_t level, const Evidence& evidence, const LabelVolume& volume, BlockBox box)
      : level_(level),
        evidence_(evidence),
        volume_(volume),
        here_(volume.levels[level]),
        box_(std::move(box)),
        extent_(box_.hi - box_.lo),
        cut_(NumberBlocks()) {
    for (const std::int32_t block : blocks_) AddBlock(block);
  }

  /// Cuts, and writes the labels of the blocks in `own`.
  void Cut(const BlockBox& own, std::vector<std::uint8_t>* solid) {
    cut_.Solve();
    for (const std::int32_t block : blocks_) {
      const Eigen::Vector3i at = here_.blocks.Block(static_cast<std::size_t>(block));
      if (!own.Contains(at)) continue;
      const std::int32_t node = nodes_[Local(at)];
      for (int place = 0; place < VoxelBlocks::kVoxels; ++place) {
        (*solid)[NumberOf(block, place)] = cut_.InSource(node + place) ? 1 : 0;
      }
    }
  }

 private:
  static std::size_t NumberOf(std::int32_t block, int place) {
    return static_cast<std::size_t>(block) * VoxelBlocks::kVoxels + static_cast<std::size_t>(place);
  }

  std::size_t Local(const Eigen::Vector3i& block) const {
    const Eigen::Vector3i at = block - box_.lo;
    return (static_cast<std::size_t>(at.z()) * static_cast<std::size_t>(extent_.y()) +
            static_cast<std::size_t>(at.y())) *
               static_cast<std::size_t>(extent_.x()) +
           static_cast<std::size_t>(at.x());
  }

  /// Lists the blocks and gives their voxels numbers as nodes. @return How many nodes there are.
  std::size_t NumberBlocks() {
    nodes_.assign(static_cast<std::size_t>(extent_.x()) * static_cast<std::size_t>(extent_.y()) *
                      static_cast<std::size_t>(extent_.z()),
                  kAbsent);
    std::int32_t next = 0;
    for (int z = box_.lo.z(); z < box_.hi.z(); ++z) {
      for (int y = box_.lo.y(); y < box_.hi.y(); ++y) {
        for (int x = box_.lo.x(); x < box_.hi.x(); ++x) {
          const std::int32_t block = here_.blocks.FindBlock({x, y, z});
          if (block == VoxelBlocks::kNone) continue;
          blocks_.push_back(block);
          nodes_[Local({x, y, z})] = next;
          next += VoxelBlocks::kVoxels;
        }
      }
    }
    return static_cast<std::size_t>(next);
  }

  std::int32_t NodeOf(const Voxel& voxel) const {
    const Eigen::Vector3i block = voxel / VoxelBlocks::kSide;
    if (voxel.minCoeff() < 0 || !box_.Contains(block)) return kAbsent;
    const std::int32_t node = nodes_[Local(block)];
    return node == kAbsent ? kAbsent : node + VoxelBlocks::PlaceOf(voxel);
  }

  void AddBlock(std::int32_t block) {
    const Eigen::Vector3i at = here_.blocks.Block(static_cast<std::size_t>(block));
    for (int place = 0; place < VoxelBlocks::kVoxels; ++place) {
      const Voxel voxel = here_.blocks.VoxelAt(static_cast<std::int64_t>(NumberOf(block, place)));
      if (!here_.frame.Contains(voxel)) continue;
      AddVoxel(voxel, nodes_[Local(at)] + place, NumberOf(block, place));
    }
  }

  void AddVoxel(const Voxel& voxel, std::int32_t node, std::size_t number) {
    const int solid = evidence_.solid[number];
    if (solid != 0) cut_.AddTerminal(node, std::max(solid, 0), std::max(-solid, 0));
    for (int axis = 0; axis < 3; ++axis) {
      AddForward(voxel + Voxel::Unit(axis), node, number);
      AddBackward(voxel - Voxel::Unit(axis), node, number);
    }
  }

  void AddForward(const Voxel& next, std::int32_t node, std::size_t number) {
    if (!here_.frame.Contains(next)) return;  // the surface may leave the box for nothing
    const std::int32_t other = NodeOf(next);
    if (other == kAbsent) {
      AddFixed(next, node, number);
      return;
    }
    const std::int64_t there = here_.blocks.Find(next);
    const int cost = (evidence_.cost[number] + evidence_.cost[static_cast<std::size_t>(there)]) / 2;
    cut_.AddLink(node, other, cost, cost);
  }

  void AddBackward(const Voxel& next, std::int32_t node, std::size_t number) {
    if (here_.frame.Contains(next) && NodeOf(next) == kAbsent) AddFixed(next, node, number);
  }

  /// A link to a voxel whose label the coarser level has settled.
  void AddFixed(const Voxel& next, std::int32_t node, std::size_t number) {
    if (level_ + 1 == volume_.levels.size()) return;
    const int cost = evidence_.cost[number];
    const bool solid = volume_.Solid(level_ + 1, next / 2);
    cut_.AddTerminal(node, solid ? cost : 0, solid ? 0 : cost);
  }

  std::size_t level_;
  const Evidence& evidence_;
  const LabelVolume& volume_;
  const LabelLevel& here_;
  BlockBox box_;
  Eigen::Vector3i extent_;
  std::vector<std::int32_t> nodes_;   // of the first voxel of each block in the box
  std::vector<std::int32_t> blocks_;  // that are there
  MinCut cut_;
};

/// The tiles in which there are blocks, in order.
std::vector<Eigen::Vector3i> TilesOf(const VoxelBlocks& blocks) {
  std::vector<VoxelBlocks::Key> keys;
  for (std::size_t i = 0; i < blocks.blocks(); ++i) {
    keys.push_back(VoxelBlocks::KeyOf(blocks.Block(i) / kTile));
  }
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::vector<Eigen::Vector3i> tiles;
  tiles.reserve(keys.size());
  for (const VoxelBlocks::Key key : keys) tiles.push_back(VoxelBlocks::BlockOf(key));
  return tiles;
}

}  // namespace

void CutLevel(std::size_t level,
              const Evidence& evidence,
              const MeshWatch& watch,
              LabelVolume* volume) {
  LabelLevel& here = volume->levels[level];
  std::vector<std::uint8_t> solid(here.blocks.voxels(), 0);
  if (level + 1 == volume->levels.size()) {
    const Eigen::Vector3i end =
        (here.frame.size.array() + VoxelBlocks::kSide - 1) / VoxelBlocks::kSide;
    const BlockBox all{Eigen::Vector3i::Zero(), end};
    TileGraph(level, evidence, *volume, all).Cut(all, &solid);
  } else {
    const std::vector<Eigen::Vector3i> tiles = TilesOf(here.blocks);
    ParallelFor(tiles.size(), [&](std::size_t i) {
      if (watch.stop && watch.stop()) return;
      const Eigen::Vector3i lo = kTile * tiles[i], hi = lo.array() + kTile;
      const BlockBox wide{(lo.array() - kMargin).max(0), hi.array() + kMargin};
      TileGraph(level, evidence, *volume, wide).Cut({lo, hi}, &solid);
    });
    watch.Check();
  }
  here.solid = std::move(solid);
}

}  // namespace livemvs
