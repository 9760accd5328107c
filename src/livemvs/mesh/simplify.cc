#include "livemvs/mesh/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "livemvs/mesh/mesh_topology.h"

namespace livemvs {
namespace {

using Faces = std::vector<Eigen::Vector3i>;

/// Faces in at most `target`, if there are more; `lock` leaves the vertices on the rims in place.
Faces Collapse(const std::vector<Eigen::Vector3f>& vertices,
               const Faces& faces,
               std::size_t target,
               bool lock) {
  if (faces.size() <= target) return faces;
  std::vector<unsigned> indices, left;
  indices.reserve(3 * faces.size());
  for (const Eigen::Vector3i& f : faces) {
    for (int k = 0; k < 3; ++k) indices.push_back(static_cast<unsigned>(f[k]));
  }
  left.resize(indices.size());
  constexpr float kAnyError = 1;
  left.resize(meshopt_simplify(left.data(),
                               indices.data(),
                               indices.size(),
                               vertices.data()->data(),
                               vertices.size(),
                               sizeof(Eigen::Vector3f),
                               3 * target,
                               kAnyError,
                               lock ? static_cast<unsigned>(meshopt_SimplifyLockBorder) : 0U,
                               nullptr));
  Faces result;
  for (std::size_t i = 0; i + 2 < left.size(); i += 3) {
    const Eigen::Vector3i f(
        static_cast<int>(left[i]), static_cast<int>(left[i + 1]), static_cast<int>(left[i + 2]));
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) result.push_back(f);
  }
  return result;
}

/// Vertices at which the mesh is no manifold or intersects itself, marked.
std::vector<char> Faults(const TriangleMesh& mesh) {
  std::vector<char> faults(mesh.vertices.size(), 0);
  const MeshTopology topology(mesh);
  const auto mark_face = [&](std::int32_t face) {
    const Eigen::Vector3i& f = mesh.faces[static_cast<std::size_t>(face)];
    for (int k = 0; k < 3; ++k) faults[static_cast<std::size_t>(f[k])] = 1;
  };
  for (const auto& [a, b] : IntersectingFaces(mesh)) {
    mark_face(a);
    mark_face(b);
  }
  for (const std::int32_t v : PinchedVertices(mesh, topology))
    faults[static_cast<std::size_t>(v)] = 1;
  for (const std::int32_t face : topology.bad_faces()) mark_face(face);
  return faults;
}

/// Marks the faces at marked vertices, and their vertices, a number of times over.
void Spread(const Faces& faces, int rings, std::vector<char>* vertices, std::vector<char>* marks) {
  for (int ring = 0; ring < rings; ++ring) {
    for (std::size_t i = 0; i < faces.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        if ((*vertices)[static_cast<std::size_t>(faces[i][k])] != 0) (*marks)[i] = 1;
      }
    }
    for (std::size_t i = 0; i < faces.size(); ++i) {
      for (int k = 0; k < 3 && (*marks)[i] != 0; ++k) {
        (*vertices)[static_cast<std::size_t>(faces[i][k])] = 1;
      }
    }
  }
}

/// Faces in about `aim` that are sound; all of them as they are, where that cannot be had.
Faces CollapseSoundly(const TriangleMesh& mesh, std::size_t aim, const MeshWatch& watch) {
  const Faces& original = mesh.faces;
  constexpr int kMostTries = 40;
  constexpr double kCoarsest = 0.7;
  constexpr std::size_t kLeastFaces = 4;
  std::vector<char> keep(original.size(), 0);  // these stay as they are
  TriangleMesh tried;
  tried.vertices = mesh.vertices;
  for (int attempt = 0; attempt < kMostTries; ++attempt) {
    watch.Check();
    Faces kept, rest;
    for (std::size_t i = 0; i < original.size(); ++i) {
      (keep[i] != 0 ? kept : rest).push_back(original[i]);
    }
    // Not much coarser than it would be without those kept: that only makes more faults.
    const auto fair = static_cast<std::size_t>(kCoarsest * static_cast<double>(aim) *
                                               static_cast<double>(rest.size()) /
                                               static_cast<double>(original.size()));
    const std::size_t target = std::max({aim - std::min(aim, kept.size()), fair, kLeastFaces});
    tried.faces = Collapse(tried.vertices, rest, target, !kept.empty());
    tried.faces.insert(tried.faces.end(), kept.begin(), kept.end());
    std::vector<char> faults = Faults(tried);
    if (std::ranges::count(faults, 0) == std::ssize(faults)) return tried.faces;
    // Only about the new faults: what is kept already does not grow.
    std::vector<char> more(original.size(), 0);
    Spread(original, 1 + attempt / 2, &faults, &more);
    for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = keep[i] != 0 || more[i] != 0 ? 1 : 0;
  }
  return original;
}

}  // namespace

bool SimplifyMesh(std::size_t faces, const MeshWatch& watch, TriangleMesh* mesh) {
  if (mesh->faces.size() <= faces) return true;
  Faces best = mesh->faces;
  std::size_t aim = faces;
  constexpr int kMostAims = 4;
  for (int i = 0; i < kMostAims && best.size() > faces && aim > 0; ++i) {
    Faces found = CollapseSoundly(*mesh, aim, watch);
    aim = aim * faces / found.size();
    if (found.size() < best.size()) best = std::move(found);
  }
  mesh->faces = std::move(best);
  RemoveFaces(std::vector<char>(mesh->faces.size(), 0), mesh);
  return mesh->faces.size() <= faces;
}

}  // namespace livemvs
