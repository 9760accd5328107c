#include "livemvs/mesh/marching.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr int kVoxels = VoxelBlocks::kVoxels;

// Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2) from its first. Edge 4 a + k runs along axis
// a from the k-th corner that has no a.
constexpr std::array<std::array<int, 4>, 3> kEdgeStarts = {
    {{0, 2, 4, 6}, {0, 1, 4, 5}, {0, 1, 2, 3}}};

int EdgeBetween(int a, int b) {
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  const auto& starts = kEdgeStarts[static_cast<std::size_t>(axis)];
  const auto at = std::ranges::find(starts, std::min(a, b)) - starts.begin();
  return 4 * axis + static_cast<int>(at);
}

// The corners of each face, counter-clockwise as seen from outside of the cell.
constexpr std::array<std::array<int, 4>, 6> kFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

/// The loops of edges that the surface cuts, for each of the 256 sets of solid corners.
struct CellCase {
  std::vector<std::vector<int>> loops;
};

CellCase TraceCase(unsigned solid) {
  const auto is_solid = [solid](int corner) { return (solid >> corner & 1) != 0; };
  std::array<int, 12> next;
  next.fill(-1);
  for (const auto& face : kFaces) {
    for (std::size_t i = 0; i < 4; ++i) {
      // Where the way about the face leaves what is solid, a segment leads to where it entered:
      // each run of solid corners has its own.
      if (!is_solid(face[i]) || is_solid(face[(i + 1) % 4])) continue;
      std::size_t first = i;
      while (is_solid(face[(first + 3) % 4])) first = (first + 3) % 4;
      next[static_cast<std::size_t>(EdgeBetween(face[(first + 3) % 4], face[first]))] =
          EdgeBetween(face[i], face[(i + 1) % 4]);
    }
  }
  CellCase result;
  std::array<bool, 12> done{};
  for (std::size_t start = 0; start < 12; ++start) {
    if (next[start] < 0 || done[start]) continue;
    std::vector<int> loop;
    for (auto edge = start; !done[edge]; edge = static_cast<std::size_t>(next[edge])) {
      done[edge] = true;
      loop.push_back(static_cast<int>(edge));
    }
    result.loops.push_back(std::move(loop));
  }
  return result;
}

const std::array<CellCase, 256>& Cases() {
  static const std::array<CellCase, 256> cases = [] {
    std::array<CellCase, 256> all;
    for (unsigned i = 0; i < 256; ++i) all[i] = TraceCase(i);
    return all;
  }();
  return cases;
}

/// Which edges from a block's voxels the surface cuts, and the number of its first vertex.
struct BlockVertices {
  std::array<std::uint64_t, 3> cut{};
  std::uint32_t first = 0;

  std::uint32_t Number(int axis, int place) const {
    std::uint32_t number = first;
    for (int a = 0; a < axis; ++a) {
      number += static_cast<std::uint32_t>(std::popcount(cut[static_cast<std::size_t>(a)]));
    }
    const std::uint64_t below = (std::uint64_t{1} << place) - 1;
    return number +
           static_cast<std::uint32_t>(std::popcount(cut[static_cast<std::size_t>(axis)] & below));
  }
};

class Marcher {
 public:
  explicit Marcher(const SurfaceField& field) : field_(field), vertices_(field.blocks.blocks()) {}

  TriangleMesh March() {
    NumberVertices();
    PlaceVertices();
    MakeFaces();
    return std::move(mesh_);
  }

 private:
  float Value(std::int64_t voxel) const { return field_.values[static_cast<std::size_t>(voxel)]; }

  template <typename F>
  void ForBlocks(const F& f) const {
    ParallelForRange(0, field_.blocks.blocks(), 64, [&](std::size_t first, std::size_t last) {
      VoxelCursor cursor(field_.blocks);
      for (std::size_t b = first; b < last; ++b) f(b, &cursor);
    });
  }

  void NumberVertices() {
    ForBlocks([&](std::size_t b, VoxelCursor* cursor) {
      for (int place = 0; place < kVoxels; ++place) {
        const auto i = static_cast<std::int64_t>(b) * kVoxels + place;
        const Voxel voxel = field_.blocks.VoxelAt(i);
        for (int axis = 0; axis < 3; ++axis) {
          const std::int64_t next = cursor->Find(voxel + Voxel::Unit(axis));
          if (next == VoxelBlocks::kNone || (Value(next) < 0) == (Value(i) < 0)) continue;
          vertices_[b].cut[static_cast<std::size_t>(axis)] |= std::uint64_t{1} << place;
        }
      }
    });
    std::uint64_t count = 0;
    for (BlockVertices& block : vertices_) {
      block.first = static_cast<std::uint32_t>(count);
      for (const std::uint64_t cut : block.cut) count += static_cast<unsigned>(std::popcount(cut));
    }
    if (count > 0x3fffffff) {
      throw Error(ErrorKind::kOutOfResource,
                  "the surface has too many vertices; choose a coarser --resolution");
    }
    mesh_.vertices.resize(count);
  }

  void PlaceVertices() {
    ForBlocks([&](std::size_t b, VoxelCursor* cursor) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int place = 0; place < kVoxels; ++place) {
          if ((vertices_[b].cut[static_cast<std::size_t>(axis)] >> place & 1) == 0) continue;
          const auto i = static_cast<std::int64_t>(b) * kVoxels + place;
          const Voxel voxel = field_.blocks.VoxelAt(i);
          const float here = Value(i), there = Value(cursor->Find(voxel + Voxel::Unit(axis)));
          // Not at the ends, where vertices of several edges would meet.
          constexpr float kEnd = 0.02F;
          const float t = std::clamp(here / (here - there), kEnd, 1 - kEnd);
          const Eigen::Vector3d at = voxel.cast<double>().array() + 0.5;
          mesh_.vertices[vertices_[b].Number(axis, place)] =
              (field_.frame.origin +
               field_.frame.h * (at + double{t} * Eigen::Vector3d::Unit(axis)))
                  .cast<float>();
        }
      }
    });
  }

  void MakeFaces() {
    VoxelCursor cursor(field_.blocks);
    for (std::size_t i = 0; i < field_.blocks.voxels(); ++i) {
      const Voxel voxel = field_.blocks.VoxelAt(static_cast<std::int64_t>(i));
      unsigned solid = 0;
      bool whole = true;
      std::array<std::int64_t, 8> corners{};
      for (int c = 0; c < 8 && whole; ++c) {
        const std::int64_t at = cursor.Find(voxel + Voxel(c & 1, c >> 1 & 1, c >> 2));
        corners[static_cast<std::size_t>(c)] = at;
        whole = at != VoxelBlocks::kNone;
        if (whole && Value(at) < 0) solid |= 1U << c;
      }
      if (!whole || solid == 0 || solid == 255) continue;
      for (const std::vector<int>& loop : Cases()[solid].loops) Close(loop, corners);
    }
  }

  int VertexOn(int edge, const std::array<std::int64_t, 8>& corners) const {
    const int axis = edge / 4;
    const int start =
        kEdgeStarts[static_cast<std::size_t>(axis)][static_cast<std::size_t>(edge % 4)];
    const std::int64_t voxel = corners[static_cast<std::size_t>(start)];
    return static_cast<int>(vertices_[static_cast<std::size_t>(voxel / kVoxels)].Number(
        axis, static_cast<int>(voxel % kVoxels)));
  }

  /// Triangles that close a loop: one, two, or a fan about a new vertex in the middle.
  void Close(const std::vector<int>& loop, const std::array<std::int64_t, 8>& corners) {
    std::array<int, 12> v{};
    const std::size_t n = loop.size();
    for (std::size_t k = 0; k < n; ++k) v[k] = VertexOn(loop[k], corners);
    if (n == 3) {
      mesh_.faces.emplace_back(v[0], v[1], v[2]);
    } else if (n == 4) {
      CloseFour(v);
    } else {
      Eigen::Vector3f middle = Eigen::Vector3f::Zero();
      for (std::size_t k = 0; k < n; ++k) middle += Vertex(v[k]) / static_cast<float>(n);
      const auto number = static_cast<int>(mesh_.vertices.size());
      mesh_.vertices.push_back(middle);
      for (std::size_t k = 0; k < n; ++k) mesh_.faces.emplace_back(v[k], v[(k + 1) % n], number);
    }
  }

  const Eigen::Vector3f& Vertex(int i) const { return mesh_.vertices[static_cast<std::size_t>(i)]; }

  void CloseFour(const std::array<int, 12>& v) {
    // Along the shorter diagonal.
    if ((Vertex(v[0]) - Vertex(v[2])).squaredNorm() <=
        (Vertex(v[1]) - Vertex(v[3])).squaredNorm()) {
      mesh_.faces.emplace_back(v[0], v[1], v[2]);
      mesh_.faces.emplace_back(v[0], v[2], v[3]);
    } else {
      mesh_.faces.emplace_back(v[1], v[2], v[3]);
      mesh_.faces.emplace_back(v[1], v[3], v[0]);
    }
  }

  const SurfaceField& field_;
  std::vector<BlockVertices> vertices_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh MarchField(const SurfaceField& field, const MeshWatch& watch) {
  watch.Check();
  return Marcher(field).March();
}

}  // namespace livemvs
