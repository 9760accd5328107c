#include "livemvs/mesh/surface_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr int kSide = VoxelBlocks::kSide;
constexpr int kBand = 3;              ///< Layers of voxels on either side whose value is open.
constexpr float kFar = kBand + 0.5F;  ///< Magnitude beyond.
/// Weight of the labels' distance, as a share of that of smoothness.
constexpr float kLabelWeight = 0.05F;
constexpr float kLeast = 1e-3F;  ///< Magnitudes below are as good as zero, and pushed away from it.

/// Samples of the field while it is made.
struct Samples {
  std::vector<std::int8_t> layer;  ///< Steps to the cut, from 1; < 0 in what is solid; beyond the
                                   ///< band kBand + 1.
  std::vector<float> target;       ///< What the points say. [voxel]
  std::vector<float> weight;       ///< How surely.
};

class FieldMaker {
 public:
  FieldMaker(const SightLines& sights, const LabelVolume& volume, const MeshOptions& options)
      : sights_(sights), volume_(volume), options_(options) {
    // One block more on each side, so that a surface can be closed there.
    field_.frame = volume.finest().frame;
    field_.frame.origin.array() -= kSide * field_.frame.h;
    field_.frame.size.array() += 2 * kSide;
  }

  SurfaceField Make(const MeshWatch& watch) {
    FindBlocks();
    FindLayers();
    watch.Check();
    AskPoints();
    watch.Check();
    Smooth(watch);
    return std::move(field_);
  }

 private:
  bool Solid(const Voxel& voxel) const {
    const Voxel inner = voxel - Voxel::Constant(kSide);
    if (options_.whole_surface && !volume_.finest().frame.Contains(inner)) return false;
    return volume_.Solid(0, inner);
  }

  /// Blocks with a voxel on the cut, and those about them.
  void FindBlocks() {
    const LabelLevel& finest = volume_.finest();
    std::vector<VoxelBlocks::Key> keys;
    VoxelCursor cursor(finest.blocks);
    for (std::size_t b = 0; b < finest.blocks.blocks(); ++b) {
      if (!HasSurface(b, &cursor)) continue;
      const Eigen::Vector3i block = finest.blocks.Block(b) + Eigen::Vector3i::Ones();
      for (int z = -1; z <= 1; ++z) {
        for (int y = -1; y <= 1; ++y) {
          for (int x = -1; x <= 1; ++x) {
            const Eigen::Vector3i other = block + Eigen::Vector3i(x, y, z);
            if ((other.array() * kSide < field_.frame.size.array()).all()) {
              keys.push_back(VoxelBlocks::KeyOf(other));
            }
          }
        }
      }
    }
    field_.blocks = VoxelBlocks(std::move(keys));
  }

  bool HasSurface(std::size_t block, VoxelCursor* cursor) const {
    const LabelLevel& finest = volume_.finest();
    for (std::size_t i = block * VoxelBlocks::kVoxels; i < (block + 1) * VoxelBlocks::kVoxels;
         ++i) {
      const Voxel voxel = finest.blocks.VoxelAt(static_cast<std::int64_t>(i));
      if (!finest.frame.Contains(voxel)) continue;
      const bool solid = finest.solid[i] != 0;
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
          const Voxel next = voxel + side * Voxel::Unit(axis);
          const std::int64_t at = cursor->Find(next);
          const bool other = at != VoxelBlocks::kNone && finest.frame.Contains(next)
                                 ? finest.solid[static_cast<std::size_t>(at)] != 0
                                 : Solid(next + Voxel::Constant(kSide));
          if (other != solid) return true;
        }
      }
    }
    return false;
  }

  /// Steps to the nearest voxel of the other label, along the axes.
  void FindLayers() {
    const std::size_t count = field_.blocks.voxels();
    samples_.layer.assign(count, kBand + 1);
    ParallelForRange(0, count, 4096, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Voxel voxel = field_.blocks.VoxelAt(static_cast<std::int64_t>(i));
        if (Solid(voxel)) samples_.layer[i] = -(kBand + 1);
      }
    });
    std::vector<std::int8_t> before;
    for (int step = 1; step <= kBand; ++step) {
      before = samples_.layer;
      ForVoxels([&](std::size_t i, const Voxel& voxel, VoxelCursor* cursor) {
        if (std::abs(before[i]) <= kBand) return;
        for (int side = 0; side < 6; ++side) {
          const std::int64_t at = cursor->Find(Neighbor(voxel, side));
          if (at == VoxelBlocks::kNone) continue;
          const std::int8_t other = before[static_cast<std::size_t>(at)];
          const bool reached = step == 1
                                   ? (other < 0) != (before[i] < 0)
                                   : (other < 0) == (before[i] < 0) && std::abs(other) == step - 1;
          if (!reached) continue;
          samples_.layer[i] = static_cast<std::int8_t>(before[i] < 0 ? -step : step);
          return;
        }
      });
    }
  }

  static Voxel Neighbor(const Voxel& voxel, int side) {
    return voxel + (side % 2 == 0 ? 1 : -1) * Voxel::Unit(side / 2);
  }

  template <typename F>
  void ForVoxels(const F& f) {
    ParallelForRange(0, field_.blocks.blocks(), 64, [&](std::size_t first, std::size_t last) {
      VoxelCursor cursor(field_.blocks);
      for (std::size_t i = first * VoxelBlocks::kVoxels; i < last * VoxelBlocks::kVoxels; ++i) {
        f(i, field_.blocks.VoxelAt(static_cast<std::int64_t>(i)), &cursor);
      }
    });
  }

  /// Whether the cut passes near the point, facing as it does.
  bool OnSurface(const SightLine& line) const {
    const Eigen::Vector3f at = field_.frame.ToGrid(line.position);
    bool solid_behind = false, empty_before = false;
    for (int step = 1; step <= kBand; ++step) {
      const Eigen::Vector3f ahead = at + static_cast<float>(step) * line.normal;
      const Eigen::Vector3f behind = at - static_cast<float>(step) * line.normal;
      empty_before = empty_before || !Solid(ahead.array().floor().cast<int>().matrix());
      solid_behind = solid_behind || Solid(behind.array().floor().cast<int>().matrix());
    }
    return solid_behind && empty_before;
  }

  /// The points on the surface, by block: those of block b are order_[starts_[b]] and on.
  void SortPoints() {
    std::vector<std::int64_t> block(sights_.lines.size(), VoxelBlocks::kNone);
    ParallelForRange(0, block.size(), 1024, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const SightLine& line = sights_.lines[i];
        if (line.normal.isZero() || !OnSurface(line)) continue;
        const Eigen::Vector3f at = field_.frame.ToGrid(line.position);
        const std::int64_t voxel = field_.blocks.Find(at.array().floor().cast<int>().matrix());
        if (voxel != VoxelBlocks::kNone) block[i] = voxel / VoxelBlocks::kVoxels;
      }
    });
    starts_.assign(field_.blocks.blocks() + 1, 0);
    for (const std::int64_t b : block) {
      if (b != VoxelBlocks::kNone) ++starts_[static_cast<std::size_t>(b) + 1];
    }
    for (std::size_t b = 1; b < starts_.size(); ++b) starts_[b] += starts_[b - 1];
    order_.resize(starts_.back());
    std::vector<std::uint32_t> at(starts_.begin(), starts_.end() - 1);
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (block[i] != VoxelBlocks::kNone) {
        order_[at[static_cast<std::size_t>(block[i])]++] = static_cast<std::uint32_t>(i);
      }
    }
  }

  /// A point as it acts on the field, in voxels.
  struct Plane {
    Eigen::Vector3f point, normal;
    float weight;
  };

  void AskPoints() {
    SortPoints();
    samples_.target.assign(field_.blocks.voxels(), 0);
    samples_.weight.assign(field_.blocks.voxels(), 0);
    ParallelForRange(0, field_.blocks.blocks(), 16, [&](std::size_t first, std::size_t last) {
      std::vector<Plane> planes;
      for (std::size_t b = first; b < last; ++b) {
        GatherPlanes(b, &planes);
        if (planes.empty()) continue;
        for (std::size_t i = b * VoxelBlocks::kVoxels; i < (b + 1) * VoxelBlocks::kVoxels; ++i) {
          if (std::abs(samples_.layer[i]) <= kBand) AskPlanes(planes, i);
        }
      }
    });
    order_ = {};
    starts_ = {};
  }

  void GatherPlanes(std::size_t block, std::vector<Plane>* planes) const {
    planes->clear();
    const Eigen::Vector3i at = field_.blocks.Block(block);
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const Eigen::Vector3i next = at + Eigen::Vector3i(x, y, z);
          const std::int32_t other =
              next.minCoeff() < 0 ? VoxelBlocks::kNone : field_.blocks.FindBlock(next);
          if (other == VoxelBlocks::kNone) continue;
          for (std::uint32_t k = starts_[static_cast<std::size_t>(other)];
               k < starts_[static_cast<std::size_t>(other) + 1];
               ++k) {
            const SightLine& line = sights_.lines[order_[k]];
            const float sigma = line.sigma / static_cast<float>(field_.frame.h);
            planes->push_back({field_.frame.ToGrid(line.position),
                               line.normal,
                               line.weight / std::max(sigma * sigma, 0.01F)});
          }
        }
      }
    }
  }

  /// Moving least squares of the planes about a voxel's centre.
  void AskPlanes(const std::vector<Plane>& planes, std::size_t i) {
    const Eigen::Vector3f center =
        field_.blocks.VoxelAt(static_cast<std::int64_t>(i)).cast<float>().array() + 0.5F;
    const float reach = std::min(static_cast<float>(options_.reach), float{kSide});
    const float s = reach / 2.5F;
    float sum = 0, weights = 0, counts = 0;
    for (const Plane& plane : planes) {
      const Eigen::Vector3f d = center - plane.point;
      const float across = d.dot(plane.normal);
      const float along2 = d.squaredNorm() - across * across;
      if (along2 > reach * reach || std::abs(across) > kFar) continue;
      const float g = std::exp(-0.5F * (along2 + 0.25F * across * across) / (s * s));
      sum += plane.weight * g * across;
      weights += plane.weight * g;
      counts += g;
    }
    if (counts < 1e-3F) return;
    samples_.target[i] = std::clamp(sum / weights, -kFar, kFar);
    samples_.weight[i] = std::min(counts, 4.0F);
  }

  /// The voxels of the band, with their neighbours in it by their place in this list.
  struct Band {
    static constexpr std::int32_t kNone = -1;
    std::vector<std::uint32_t> voxels;
    std::vector<std::array<std::int32_t, 6>> neighbors;
  };

  Band MakeBand() {
    Band band;
    std::vector<std::int32_t> place(samples_.layer.size(), Band::kNone);
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (std::abs(samples_.layer[i]) > kBand) continue;
      place[i] = static_cast<std::int32_t>(band.voxels.size());
      band.voxels.push_back(static_cast<std::uint32_t>(i));
    }
    band.neighbors.resize(band.voxels.size());
    ForVoxels([&](std::size_t i, const Voxel& voxel, VoxelCursor* cursor) {
      if (place[i] == Band::kNone) return;
      auto& neighbors = band.neighbors[static_cast<std::size_t>(place[i])];
      for (int side = 0; side < 6; ++side) {
        const std::int64_t at = cursor->Find(Neighbor(voxel, side));
        neighbors[static_cast<std::size_t>(side)] =
            at == VoxelBlocks::kNone ? Band::kNone : place[static_cast<std::size_t>(at)];
      }
    });
    return band;
  }

  /// Values that agree with the points and with their neighbours: Jacobi steps of Eq. (5).
  void Smooth(const MeshWatch& watch) {
    const Band band = MakeBand();
    std::vector<float> f(band.voxels.size()), before;
    for (std::size_t k = 0; k < f.size(); ++k) {
      const std::size_t i = band.voxels[k];
      f[k] = samples_.weight[i] > 0 ? samples_.target[i] : Distance(samples_.layer[i]);
    }
    const int rounds = options_.smoothing > 0 ? options_.smoothing_rounds : 0;
    for (int round = 0; round < rounds; ++round) {
      watch.Check();
      watch.Show("surface", static_cast<double>(round) / rounds);
      std::swap(before, f);
      f.resize(before.size());
      ParallelForRange(0, f.size(), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) f[k] = Smoothed(band, before, k);
      });
    }
    field_.values.resize(field_.blocks.voxels());
    for (std::size_t i = 0; i < field_.values.size(); ++i) {
      field_.values[i] = Distance(samples_.layer[i]);
    }
    for (std::size_t k = 0; k < f.size(); ++k) {
      field_.values[band.voxels[k]] = KeepSide(f[k], samples_.layer[band.voxels[k]]);
    }
  }

  float Smoothed(const Band& band, const std::vector<float>& before, std::size_t k) const {
    float sum = 0, count = 0;
    for (const std::int32_t next : band.neighbors[k]) {
      if (next == Band::kNone) continue;
      sum += before[static_cast<std::size_t>(next)];
      count += 1;
    }
    const std::size_t i = band.voxels[k];
    const auto smoothness = static_cast<float>(options_.smoothing);
    const float points = samples_.weight[i], labels = kLabelWeight * smoothness;
    const float smooth = count > 0 ? smoothness : 0;
    return (points * samples_.target[i] + labels * Distance(samples_.layer[i]) +
            smooth * (count > 0 ? sum / count : 0)) /
           (points + labels + smooth);
  }

  /// The distance that the label says. [voxel]
  static float Distance(int layer) {
    return static_cast<float>(layer) - (layer > 0 ? 0.5F : -0.5F);
  }

  /// Beyond two voxels from the cut the label holds.
  static float KeepSide(float value, int layer) {
    if (layer > 2) return std::max(value, 0.1F);
    if (layer < -2) return std::min(value, -0.1F);
    if (std::abs(value) >= kLeast) return value;
    return value < 0 || (value == 0 && layer < 0) ? -kLeast : kLeast;
  }

  const SightLines& sights_;
  const LabelVolume& volume_;
  const MeshOptions& options_;
  SurfaceField field_;
  Samples samples_;
  std::vector<std::uint32_t> starts_, order_;
};

}  // namespace

SurfaceField MakeSurfaceField(const SightLines& sights,
                              const LabelVolume& volume,
                              const MeshOptions& options,
                              const MeshWatch& watch) {
  watch.Show("surface", 0);
  return FieldMaker(sights, volume, options).Make(watch);
}

}  // namespace livemvs
