#include "livemvs/mesh/mesh_topology.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// One side of an edge; sorts beside the others of the same edge.
struct HalfEdge {
  std::int32_t low, high;
  std::int32_t face;
  std::int8_t edge;
  bool forth;  ///< From low to high.

  bool SameEdge(const HalfEdge& o) const { return low == o.low && high == o.high; }
  bool operator<(const HalfEdge& o) const {
    return low != o.low ? low < o.low : high != o.high ? high < o.high : face < o.face;
  }
};

int Corner(const TriangleMesh& mesh, std::size_t face, int k) { return mesh.faces[face][k % 3]; }

/// The faces at each vertex: `faces` from starts[v] on.
struct VertexFaces {
  explicit VertexFaces(const TriangleMesh& mesh) : starts(mesh.vertices.size() + 1, 0) {
    for (const Eigen::Vector3i& f : mesh.faces) {
      for (int k = 0; k < 3; ++k) ++starts[static_cast<std::size_t>(f[k]) + 1];
    }
    for (std::size_t v = 1; v < starts.size(); ++v) starts[v] += starts[v - 1];
    faces.resize(static_cast<std::size_t>(starts.back()));
    std::vector<std::int32_t> at(starts.begin(), starts.end() - 1);
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        faces[static_cast<std::size_t>(at[static_cast<std::size_t>(mesh.faces[i][k])]++)] =
            static_cast<std::int32_t>(i);
      }
    }
  }
  std::vector<std::int32_t> starts, faces;
};

/// The fans of faces about a vertex, joined over edges that end there.
std::vector<std::vector<std::int32_t>> FansOf(std::int32_t vertex,
                                              const VertexFaces& of,
                                              const TriangleMesh& mesh,
                                              const MeshTopology& topology) {
  const auto begin = of.faces.begin() + of.starts[static_cast<std::size_t>(vertex)];
  const auto end = of.faces.begin() + of.starts[static_cast<std::size_t>(vertex) + 1];
  std::vector<std::int32_t> left(begin, end);
  std::vector<std::vector<std::int32_t>> fans;
  while (!left.empty()) {
    std::vector<std::int32_t> fan = {left.back()};
    left.pop_back();
    for (std::size_t i = 0; i < fan.size(); ++i) {
      const auto face = static_cast<std::size_t>(fan[i]);
      for (int edge = 0; edge < 3; ++edge) {
        if (Corner(mesh, face, edge) != vertex && Corner(mesh, face, edge + 1) != vertex) continue;
        const auto next = std::ranges::find(left, topology.Neighbor(face, edge));
        if (next == left.end()) continue;
        fan.push_back(*next);
        left.erase(next);
      }
    }
    fans.push_back(std::move(fan));
  }
  return fans;
}

}  // namespace

MeshTopology::MeshTopology(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.faces.size());
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int a = Corner(mesh, i, k), b = Corner(mesh, i, k + 1);
      edges.push_back({std::min(a, b),
                       std::max(a, b),
                       static_cast<std::int32_t>(i),
                       static_cast<std::int8_t>(k),
                       a < b});
    }
  }
  std::sort(edges.begin(), edges.end());
  neighbors_.assign(mesh.faces.size(), {kNone, kNone, kNone});
  const auto neighbor = [&](const HalfEdge& e) -> std::int32_t& {
    return neighbors_[static_cast<std::size_t>(e.face)][static_cast<std::size_t>(e.edge)];
  };
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].SameEdge(edges[i])) ++end;
    if (end - i == 1) {
      ++border_edges_;
    } else if (end - i == 2 && edges[i].forth != edges[i + 1].forth) {
      neighbor(edges[i]) = edges[i + 1].face;
      neighbor(edges[i + 1]) = edges[i].face;
    } else {
      ++bad_edges_;
      for (std::size_t k = i; k < end; ++k) bad_faces_.push_back(edges[k].face);
    }
    i = end;
  }
}

std::vector<std::int32_t> MeshTopology::Components(std::size_t* count) const {
  std::vector<std::int32_t> component(neighbors_.size(), kNone);
  std::vector<std::int32_t> open;
  *count = 0;
  for (std::size_t seed = 0; seed < component.size(); ++seed) {
    if (component[seed] != kNone) continue;
    const auto number = static_cast<std::int32_t>((*count)++);
    component[seed] = number;
    open.push_back(static_cast<std::int32_t>(seed));
    while (!open.empty()) {
      const auto face = static_cast<std::size_t>(open.back());
      open.pop_back();
      for (const std::int32_t next : neighbors_[face]) {
        if (next == kNone || component[static_cast<std::size_t>(next)] != kNone) continue;
        component[static_cast<std::size_t>(next)] = number;
        open.push_back(next);
      }
    }
  }
  return component;
}

std::vector<std::int32_t> PinchedVertices(const TriangleMesh& mesh, const MeshTopology& topology) {
  const VertexFaces of(mesh);
  std::vector<std::int32_t> pinched;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (of.starts[v + 1] - of.starts[v] < 2) continue;
    if (FansOf(static_cast<std::int32_t>(v), of, mesh, topology).size() > 1) {
      pinched.push_back(static_cast<std::int32_t>(v));
    }
  }
  return pinched;
}

std::size_t MarkPinches(const TriangleMesh& mesh,
                        const MeshTopology& topology,
                        std::vector<char>* marks) {
  const VertexFaces of(mesh);
  std::size_t pinched = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (of.starts[v + 1] - of.starts[v] < 2) continue;
    const auto fans = FansOf(static_cast<std::int32_t>(v), of, mesh, topology);
    if (fans.size() < 2) continue;
    ++pinched;
    const auto largest = std::ranges::max_element(fans, {}, [](const auto& f) { return f.size(); });
    for (auto fan = fans.begin(); fan != fans.end(); ++fan) {
      if (fan == largest) continue;
      for (const std::int32_t face : *fan) (*marks)[static_cast<std::size_t>(face)] = 1;
    }
  }
  return pinched;
}

void RemoveFaces(const std::vector<char>& marks, TriangleMesh* mesh) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh->faces.size(); ++i) {
    if (marks[i] == 0) mesh->faces[kept++] = mesh->faces[i];
  }
  mesh->faces.resize(kept);
  std::vector<std::int32_t> number(mesh->vertices.size(), -1);
  for (const Eigen::Vector3i& f : mesh->faces) {
    for (int k = 0; k < 3; ++k) number[static_cast<std::size_t>(f[k])] = 0;
  }
  std::int32_t next = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    mesh->vertices[static_cast<std::size_t>(next)] = mesh->vertices[v];
    if (!mesh->colors.empty()) mesh->colors[static_cast<std::size_t>(next)] = mesh->colors[v];
    number[v] = next++;
  }
  mesh->vertices.resize(static_cast<std::size_t>(next));
  if (!mesh->colors.empty()) mesh->colors.resize(static_cast<std::size_t>(next));
  for (Eigen::Vector3i& f : mesh->faces) {
    for (int k = 0; k < 3; ++k) f[k] = number[static_cast<std::size_t>(f[k])];
  }
}

double FaceArea(const TriangleMesh& mesh, std::size_t face) {
  const auto corner = [&](int k) -> Eigen::Vector3d {
    return mesh.vertices[static_cast<std::size_t>(mesh.faces[face][k])].cast<double>();
  };
  return 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
}

}  // namespace livemvs
