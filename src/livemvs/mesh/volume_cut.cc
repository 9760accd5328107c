#include "livemvs/mesh/volume_cut.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "livemvs/core/error.h"
#include "livemvs/mesh/tile_cut.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

using Keys = std::vector<VoxelBlocks::Key>;

/// Voxels between the points and the sides of the box, at least: of the finest level and of the
/// coarsest, whose surface must find room behind the points.
constexpr double kFineMargin = 10, kCoarseMargin = 4;
/// The coarsest level has no more voxels than this, ...
constexpr double kMostCoarseVoxels = 600'000;
constexpr std::size_t kMostLevels = 21;
/// What a voxel of the finest level takes while its level is cut and its surface is drawn, all
/// told.
constexpr std::size_t kBytesPerVoxel = 30;

/// Most voxels along an axis.
constexpr double kMostVoxelsAcross = 2.0 * VoxelBlocks::kMostBlocks;

/// The frames of all levels, the finest first; none where there would be too many voxels.
std::vector<VoxelFrame> MakeFrames(const SightLines& sights, double h) {
  Eigen::Vector3d lo = sights.lines.front().position.cast<double>(), hi = lo;
  for (const SightLine& l : sights.lines) {
    lo = lo.cwiseMin(l.position.cast<double>());
    hi = hi.cwiseMax(l.position.cast<double>());
  }
  std::size_t levels = 1;
  double scale = 1;
  const auto extent_of = [&](double coarsest) -> Eigen::Array3d {
    return (hi - lo).array() / h + 2 * std::max(kFineMargin, kCoarseMargin * coarsest) + 1;
  };
  while (levels < kMostLevels && (extent_of(scale) / scale).ceil().prod() > kMostCoarseVoxels) {
    ++levels;
    scale *= 2;
  }
  const Eigen::Array3d extent = extent_of(scale);
  if (!(extent.maxCoeff() < kMostVoxelsAcross)) return {};
  // Whole blocks of the coarsest level, with the points in the middle.
  const double unit = scale * VoxelBlocks::kSide;
  const Eigen::Array3d size = (extent / unit).ceil() * unit;
  VoxelFrame finest;
  finest.h = h;
  finest.origin = (0.5 * (lo + hi).array() - 0.5 * h * size).matrix();
  std::vector<VoxelFrame> frames;
  for (std::size_t l = 0; l < levels; ++l) {
    VoxelFrame frame = finest;
    const double factor = std::ldexp(1.0, static_cast<int>(l));
    frame.h = h * factor;
    frame.size = (size / factor).cast<int>().matrix();
    frames.push_back(frame);
  }
  return frames;
}

void AddBlocksAbout(const Voxel& voxel, int reach, const VoxelFrame& frame, Keys* keys) {
  const Voxel lo = (voxel.array() - reach).max(0) / VoxelBlocks::kSide;
  const Voxel hi = (voxel.array() + reach).min(frame.size.array() - 1) / VoxelBlocks::kSide;
  for (int z = lo.z(); z <= hi.z(); ++z) {
    for (int y = lo.y(); y <= hi.y(); ++y) {
      for (int x = lo.x(); x <= hi.x(); ++x) keys->push_back(VoxelBlocks::KeyOf({x, y, z}));
    }
  }
}

void Compact(Keys* keys) {
  std::ranges::sort(*keys);
  keys->erase(std::unique(keys->begin(), keys->end()), keys->end());
}

/// Blocks within `reach` voxels of a point.
Keys BlocksAboutPoints(const SightLines& sights, const VoxelFrame& frame, int reach) {
  Keys keys;
  std::size_t compact_at = 1 << 22;
  for (const SightLine& l : sights.lines) {
    AddBlocksAbout(
        frame.ToGrid(l.position).array().floor().cast<int>().matrix(), reach, frame, &keys);
    if (keys.size() < compact_at) continue;
    Compact(&keys);
    compact_at = 2 * keys.size() + (1 << 22);
  }
  Compact(&keys);
  return keys;
}

/// Blocks about the surface of the next coarser level: `reach` fine voxels beyond its voxels.
/// @param closed  The sides of the box are surface, too, where they cut through what is solid.
void AddBlocksAboutSurface(
    const LabelVolume& volume, std::size_t coarse, int reach, bool closed, Keys* keys) {
  const LabelLevel& level = volume.levels[coarse];
  const VoxelFrame& fine = volume.levels[coarse - 1].frame;
  VoxelCursor cursor(level.blocks);
  for (std::size_t i = 0; i < level.blocks.voxels(); ++i) {
    const Voxel voxel = level.blocks.VoxelAt(static_cast<std::int64_t>(i));
    if (!level.frame.Contains(voxel)) continue;
    bool surface = false;
    for (int axis = 0; axis < 3 && !surface; ++axis) {
      for (const int side : {-1, 1}) {
        const Voxel next = voxel + side * Voxel::Unit(axis);
        if (!level.frame.Contains(next)) {
          surface = surface || (closed && level.solid[i] != 0);
          continue;
        }
        const std::int64_t at = cursor.Find(next);
        const bool solid = at == VoxelBlocks::kNone
                               ? volume.Solid(coarse, next)
                               : level.solid[static_cast<std::size_t>(at)] != 0;
        surface = surface || solid != (level.solid[i] != 0);
      }
    }
    if (!surface) continue;
    AddBlocksAbout(2 * voxel, reach, fine, keys);
    AddBlocksAbout(2 * voxel + Voxel::Ones(), reach, fine, keys);
  }
}

Keys AllBlocks(const VoxelFrame& frame) {
  Keys keys;
  AddBlocksAbout(frame.size / 2, frame.size.maxCoeff(), frame, &keys);
  return keys;
}

/// The frames with the finest voxels that fit the memory.
std::vector<VoxelFrame> FitFrames(const SightLines& sights, const MeshOptions& options) {
  double h = options.resolution > 0 ? options.resolution : sights.spacing;
  constexpr int kMostTries = 60;
  constexpr double kCoarser = 1.2, kShareOfSurface = 1.5;
  for (int i = 0; i < kMostTries; ++i, h *= kCoarser) {
    const std::vector<VoxelFrame> frames = MakeFrames(sights, h);
    if (frames.empty()) continue;
    const auto blocks = static_cast<double>(BlocksAboutPoints(sights, frames.front(), 2).size());
    const double bytes = kShareOfSurface * blocks * VoxelBlocks::kVoxels * kBytesPerVoxel;
    if (bytes <= 1e6 * static_cast<double>(options.memory_mb)) return frames;
  }
  throw Error(ErrorKind::kOutOfResource,
              "the surface does not fit into " + std::to_string(options.memory_mb) +
                  " MB; allow more with --memory, or choose a coarser --resolution");
}

/// Whether the voxel and its six neighbours have the same label.
bool Uniform(const LabelVolume& volume, std::size_t level, const Voxel& voxel, bool solid) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      if (volume.Solid(level, voxel + side * Voxel::Unit(axis)) != solid) return false;
    }
  }
  return true;
}

/// Lets the next coarser level speak too, but for the voxels at its surface, which may be one of
/// its voxels off: where points are sparse for this level's voxels, little else does.
/// @param trust  Log-odds of its labels, by lambda.
void TrustCoarser(const LabelVolume& volume, std::size_t l, double trust, Evidence* evidence) {
  constexpr int kHalf = VoxelBlocks::kSide / 2, kCoarse = kHalf * kHalf * kHalf;
  constexpr std::size_t kGrain = 256;
  const VoxelBlocks& blocks = volume.levels[l].blocks;
  const auto amount =
      static_cast<int>(std::lround(std::min<double>(kCapacityScale * trust, 2 * kMostEvidence)));
  ParallelForRange(0, blocks.blocks(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) {
      for (int k = 0; k < kCoarse; ++k) {
        const Voxel at(k % kHalf, k / kHalf % kHalf, k / (kHalf * kHalf));
        const Voxel coarse = kHalf * blocks.Block(b) + at;
        const bool solid = volume.Solid(l + 1, coarse);
        if (!Uniform(volume, l + 1, coarse, solid)) continue;
        for (int child = 0; child < 8; ++child) {
          const Voxel place = 2 * at + Voxel(child & 1, child >> 1 & 1, child >> 2);
          std::int16_t& sum =
              evidence->solid[b * VoxelBlocks::kVoxels +
                              static_cast<std::size_t>(VoxelBlocks::PlaceOf(place))];
          sum = static_cast<std::int16_t>(
              std::clamp(sum + (solid ? amount : -amount), -kMostEvidence, kMostEvidence));
        }
      }
    }
  });
}

}  // namespace

bool LabelVolume::Solid(std::size_t level, Voxel voxel) const {
  voxel = voxel.cwiseMax(0).cwiseMin(levels[level].frame.size - Voxel::Ones());
  for (std::size_t l = level; l < levels.size(); ++l, voxel /= 2) {
    if (levels[l].solid.empty()) continue;
    const std::int64_t number = levels[l].blocks.Find(voxel);
    if (number != VoxelBlocks::kNone) return levels[l].solid[static_cast<std::size_t>(number)] != 0;
  }
  return false;
}

LabelVolume CutVolume(const SightLines& sights,
                      const MeshOptions& options,
                      const MeshWatch& watch) {
  LabelVolume volume;
  for (VoxelFrame& frame : FitFrames(sights, options)) {
    volume.levels.push_back({std::move(frame), {}, {}});
  }
  constexpr int kPointReach = 3, kSurfaceReach = 3;
  for (std::size_t l = volume.levels.size(); l-- > 0;) {
    watch.Show("cut", 1 - (static_cast<double>(l) + 1) / static_cast<double>(volume.levels.size()));
    LabelLevel& level = volume.levels[l];
    if (l + 1 == volume.levels.size()) {
      level.blocks = VoxelBlocks(AllBlocks(level.frame));
    } else {
      Keys keys = BlocksAboutPoints(sights, level.frame, kPointReach);
      AddBlocksAboutSurface(volume, l + 1, kSurfaceReach, options.whole_surface, &keys);
      level.blocks = VoxelBlocks(std::move(keys));
    }
    // What was seen nowhere is solid in the coarsest cut; the others take it from there.
    MeshOptions of_level = options;
    if (l + 1 != volume.levels.size()) of_level.inside_prior = 0;
    Evidence evidence = GatherEvidence(sights.lines, level.frame, level.blocks, of_level, watch);
    if (l + 1 != volume.levels.size()) {
      TrustCoarser(volume, l, options.lambda * options.coarse_trust, &evidence);
    }
    CutLevel(l, evidence, watch, &volume);
  }
  return volume;
}

}  // namespace livemvs
