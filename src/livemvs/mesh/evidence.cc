#include "livemvs/mesh/evidence.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// One unit of evidence or of votes as an integer.
constexpr float kUnit = 256;

/// Sums of one kind of evidence, to which all threads add.
class Sums {
 public:
  explicit Sums(std::size_t voxels) : values_(voxels, 0) {}

  void Add(std::int64_t voxel, float amount) {
    constexpr std::uint32_t kEnough = 1U << 30;  // beyond every limit; the rest may be left out
    const auto units = static_cast<std::uint32_t>(amount * kUnit + 0.5F);
    const std::atomic_ref sum(values_[static_cast<std::size_t>(voxel)]);
    if (sum.load(std::memory_order_relaxed) < kEnough) {
      sum.fetch_add(units, std::memory_order_relaxed);
    }
  }
  double At(std::size_t voxel) const { return values_[voxel] / double{kUnit}; }

 private:
  std::vector<std::uint32_t> values_;
};

class Gatherer {
 public:
  Gatherer(const VoxelFrame& frame, const VoxelBlocks& blocks)
      : frame_(frame),
        blocks_(blocks),
        free_(blocks.voxels()),
        behind_(blocks.voxels()),
        votes_(blocks.voxels()) {}

  void Add(const SightLine& line, VoxelCursor* cursor) {
    Carve(line, cursor);
    FillBehind(line, cursor);
    Vote(line, cursor);
  }

  Evidence Take(const MeshOptions& o) const {
    Evidence evidence{std::vector<std::int16_t>(blocks_.voxels()),
                      std::vector<std::uint16_t>(blocks_.voxels())};
    ParallelForRange(0, blocks_.voxels(), 4096, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        // Lambda, Eq. (2), and rho, Eq. (3).
        const double solid = o.inside_prior +
                             std::min(o.inside_gain * behind_.At(i), o.inside_limit) -
                             std::min(o.free_gain * free_.At(i), o.free_limit);
        evidence.solid[i] = static_cast<std::int16_t>(std::lround(
            std::clamp<double>(kCapacityScale * o.lambda * solid, -kMostEvidence, kMostEvidence)));
        const double rho = std::max(o.rho_min, std::exp(-o.vote_gain * votes_.At(i)));
        evidence.cost[i] = static_cast<std::uint16_t>(std::lround(kCapacityScale * rho));
      }
    });
    return evidence;
  }

 private:
  float h() const { return static_cast<float>(frame_.h); }

  static Voxel VoxelOf(const Eigen::Vector3f& in_grid) {
    return in_grid.array().floor().cast<int>().matrix();
  }

  /// Empty, from before the point's uncertainty to the camera. Blocks that are not there are
  /// stepped over as a whole.
  void Carve(const SightLine& line, VoxelCursor* cursor) {
    if (line.direction.isZero()) return;
    const Eigen::Vector3f start = frame_.ToGrid(line.position);
    const float before = 0.75F + line.sigma / h();
    const float end = std::min(line.length / h(), GridExit(start, line.direction));
    for (float t = before; t < end;) {
      const Eigen::Vector3f at = start + t * line.direction;
      const Voxel voxel = VoxelOf(at);
      const std::int64_t number = cursor->Find(voxel);
      if (number == VoxelBlocks::kNone) {
        t += std::max(1.0F, BlockExit(at, line.direction));
        continue;
      }
      free_.Add(number, line.weight);
      t += 1;
    }
  }

  /// How far a ray goes on until it leaves the grid. [voxel]
  float GridExit(const Eigen::Vector3f& start, const Eigen::Vector3f& direction) const {
    float exit = 1e9F;
    for (int axis = 0; axis < 3; ++axis) {
      const float d = direction[axis];
      if (d > 0) exit = std::min(exit, (static_cast<float>(frame_.size[axis]) - start[axis]) / d);
      if (d < 0) exit = std::min(exit, -start[axis] / d);
    }
    return std::max(exit, 0.0F);
  }

  /// How far a ray goes on until it leaves its block. [voxel]
  static float BlockExit(const Eigen::Vector3f& at, const Eigen::Vector3f& direction) {
    constexpr float kSide = VoxelBlocks::kSide;
    float exit = 2 * kSide;
    for (int axis = 0; axis < 3; ++axis) {
      const float d = direction[axis];
      const float low = std::floor(at[axis] / kSide) * kSide;
      if (d > 0) exit = std::min(exit, (low + kSide - at[axis]) / d);
      if (d < 0) exit = std::min(exit, (low - at[axis]) / d);
    }
    return exit + 1e-3F;
  }

  /// Solid, just behind the surface.
  void FillBehind(const SightLine& line, VoxelCursor* cursor) {
    const Eigen::Vector3f& outward = line.normal.isZero() ? line.direction : line.normal;
    if (outward.isZero()) return;
    const Eigen::Vector3f start = frame_.ToGrid(line.position);
    const float first = 0.75F + std::min(line.sigma / h(), 2.0F);
    for (int step = 0; step < 3; ++step) {
      const float depth = first + 0.75F * static_cast<float>(step);
      const std::int64_t number = cursor->Find(VoxelOf(start - depth * outward));
      if (number != VoxelBlocks::kNone) behind_.Add(number, line.weight);
    }
  }

  /// The point is likely on the surface: a Gaussian about it.
  void Vote(const SightLine& line, VoxelCursor* cursor) {
    const Eigen::Vector3f at = frame_.ToGrid(line.position);
    const float s = std::clamp(line.sigma / h(), 0.7F, 1.2F);
    const float weight = line.weight * std::min(1.0F, 1.2F * h() / std::max(line.sigma, 1e-30F));
    constexpr int kReach = 2;
    const Voxel center = VoxelOf(at);
    std::array<std::array<float, 2 * kReach + 1>, 3> g{};
    for (int axis = 0; axis < 3; ++axis) {
      for (int d = -kReach; d <= kReach; ++d) {
        const float x = static_cast<float>(center[axis] + d) + 0.5F - at[axis];
        g[static_cast<std::size_t>(axis)][static_cast<std::size_t>(d + kReach)] =
            std::exp(-0.5F * x * x / (s * s));
      }
    }
    for (std::size_t k = 0; k <= 2 * kReach; ++k) {
      for (std::size_t j = 0; j <= 2 * kReach; ++j) {
        for (std::size_t i = 0; i <= 2 * kReach; ++i) {
          const float vote = weight * g[0][i] * g[1][j] * g[2][k];
          if (vote < 0.5F / kUnit) continue;
          const Voxel voxel = center +
                              Voxel(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k)) -
                              Voxel::Constant(kReach);
          const std::int64_t number = cursor->Find(voxel);
          if (number != VoxelBlocks::kNone) votes_.Add(number, vote);
        }
      }
    }
  }

  const VoxelFrame& frame_;
  const VoxelBlocks& blocks_;
  Sums free_, behind_, votes_;
};

}  // namespace

Evidence GatherEvidence(const std::vector<SightLine>& lines,
                        const VoxelFrame& frame,
                        const VoxelBlocks& blocks,
                        const MeshOptions& options,
                        const MeshWatch& watch) {
  Gatherer gatherer(frame, blocks);
  constexpr std::size_t kBatch = 65536, kGrain = 512;
  for (std::size_t begin = 0; begin < lines.size(); begin += kBatch) {
    watch.Check();
    ParallelForRange(begin,
                     std::min(begin + kBatch, lines.size()),
                     kGrain,
                     [&](std::size_t first, std::size_t last) {
                       VoxelCursor cursor(blocks);
                       for (std::size_t i = first; i < last; ++i) gatherer.Add(lines[i], &cursor);
                     });
  }
  return gatherer.Take(options);
}

}  // namespace livemvs
