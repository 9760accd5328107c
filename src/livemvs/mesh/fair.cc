#include "livemvs/mesh/fair.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "livemvs/mesh/mesh_topology.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// The neighbours of each vertex along edges: neighbors from starts[v] on, with repetitions, each
/// as often as it has faces in common.
struct VertexGraph {
  explicit VertexGraph(const TriangleMesh& mesh) : starts(mesh.vertices.size() + 1, 0) {
    for (const Eigen::Vector3i& f : mesh.faces) {
      for (int k = 0; k < 3; ++k) starts[static_cast<std::size_t>(f[k]) + 1] += 2;
    }
    for (std::size_t v = 1; v < starts.size(); ++v) starts[v] += starts[v - 1];
    neighbors.resize(starts.back());
    std::vector<std::uint32_t> at(starts.begin(), starts.end() - 1);
    for (const Eigen::Vector3i& f : mesh.faces) {
      for (int k = 0; k < 3; ++k) {
        std::uint32_t& place = at[static_cast<std::size_t>(f[k])];
        neighbors[place++] = f[(k + 1) % 3];
        neighbors[place++] = f[(k + 2) % 3];
      }
    }
  }
  std::vector<std::uint32_t> starts;
  std::vector<std::int32_t> neighbors;
};

void FixRims(const TriangleMesh& mesh, std::vector<char>* free) {
  const MeshTopology topology(mesh);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (topology.Neighbor(i, k) != MeshTopology::kNone) continue;
      (*free)[static_cast<std::size_t>(mesh.faces[i][k])] = 0;
      (*free)[static_cast<std::size_t>(mesh.faces[i][(k + 1) % 3])] = 0;
    }
  }
}

/// Puts the vertices of intersecting faces, and those about them, back. @return Whether there were
/// any that had moved.
bool GoBack(const std::vector<Eigen::Vector3f>& before,
            const VertexGraph& graph,
            TriangleMesh* mesh) {
  std::vector<char> back(mesh->vertices.size(), 0);
  for (const auto& pair : IntersectingFaces(*mesh)) {
    for (const std::int32_t face : pair) {
      for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(mesh->faces[static_cast<std::size_t>(face)][k]);
        back[v] = 1;
        for (std::uint32_t n = graph.starts[v]; n < graph.starts[v + 1]; ++n) {
          back[static_cast<std::size_t>(graph.neighbors[n])] = 1;
        }
      }
    }
  }
  bool moved = false;
  for (std::size_t v = 0; v < back.size(); ++v) {
    if (back[v] == 0 || mesh->vertices[v] == before[v]) continue;
    mesh->vertices[v] = before[v];
    moved = true;
  }
  return moved;
}

}  // namespace

void FairMesh(const std::vector<char>& free,
              int rounds,
              const MeshWatch& watch,
              TriangleMesh* mesh) {
  std::vector<char> moves = free;
  FixRims(*mesh, &moves);
  const VertexGraph graph(*mesh);
  const std::vector<Eigen::Vector3f> original = mesh->vertices;
  std::vector<Eigen::Vector3f> before;
  for (int round = 0; round < rounds; ++round) {
    watch.Check();
    watch.Show("fair", static_cast<double>(round) / rounds);
    before = mesh->vertices;
    ParallelForRange(0, before.size(), 1024, [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v) {
        if (moves[v] == 0 || graph.starts[v] == graph.starts[v + 1]) continue;
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (std::uint32_t n = graph.starts[v]; n < graph.starts[v + 1]; ++n) {
          sum += before[static_cast<std::size_t>(graph.neighbors[n])];
        }
        const auto count = static_cast<float>(graph.starts[v + 1] - graph.starts[v]);
        constexpr float kStep = 0.7F;
        mesh->vertices[v] = (1 - kStep) * before[v] + kStep / count * sum;
      }
    });
  }
  constexpr int kMostRetreats = 20;
  for (int i = 0; i < kMostRetreats; ++i) {
    watch.Check();
    if (!GoBack(original, graph, mesh)) return;
  }
  mesh->vertices = original;
}

}  // namespace livemvs
