#include "livemvs/mesh/facing.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "livemvs/eval/surface.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// Cameras that are asked, at most.
constexpr std::size_t kMostCameras = 48;

struct Viewer {
  Projector projector;
  Camera camera;
  Rigid3d cam_from_world;
  Eigen::Vector3f center;
};

/// Some of the cameras, evenly along the film.
std::vector<Viewer> ChooseViewers(const MeshCameras& cameras) {
  std::vector<Viewer> viewers;
  const std::size_t count = std::min(kMostCameras, cameras.size());
  std::size_t i = 0, next = 0;
  for (const auto& [index, c] : cameras) {
    if (i++ != next * cameras.size() / count) continue;
    ++next;
    viewers.push_back({Projector(c.camera), c.camera, c.cam_from_world, c.Center()});
  }
  return viewers;
}

float FacingOf(const Eigen::Vector3f& vertex,
               const Eigen::Vector3f& normal,
               const std::vector<Viewer>& viewers,
               const MeshSurface& surface,
               float farthest) {
  float best = 0, second = 0;
  for (const Viewer& v : viewers) {
    const Eigen::Vector3f to_vertex = vertex - v.center;
    const float length = to_vertex.norm();
    const float facing = -normal.dot(to_vertex) / length;
    if (!(facing > second)) continue;
    const auto pixel = v.projector.Project(v.cam_from_world * vertex.cast<double>());
    if (!pixel || !v.camera.Contains(*pixel, 0)) continue;
    if (surface.IsBlocked(v.center, to_vertex, 1 - std::min(farthest / length, 1.0F))) continue;
    second = std::min(best, facing);
    best = std::max(best, facing);
  }
  return second;
}

}  // namespace

std::vector<float> FacingOfVertices(const TriangleMesh& mesh,
                                    const MeshCameras& cameras,
                                    const std::vector<char>& asked,
                                    double farthest) {
  std::vector<float> facing(mesh.vertices.size(), 0);
  if (mesh.faces.empty() || cameras.empty()) return facing;
  const std::vector<Viewer> viewers = ChooseViewers(cameras);
  const std::vector<Eigen::Vector3f> normals = VertexNormals(mesh);
  const MeshSurface surface(mesh);
  ParallelForRange(0, facing.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (asked[i] == 0) continue;
      facing[i] =
          FacingOf(mesh.vertices[i], normals[i], viewers, surface, static_cast<float>(farthest));
    }
  });
  return facing;
}

std::vector<Eigen::Vector3f> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const Eigen::Vector3i& f : mesh.faces) {
    const auto corner = [&](int k) -> const Eigen::Vector3f& {
      return mesh.vertices[static_cast<std::size_t>(f[k])];
    };
    const Eigen::Vector3f n = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    for (int k = 0; k < 3; ++k) normals[static_cast<std::size_t>(f[k])] += n;
  }
  for (Eigen::Vector3f& n : normals) {
    const float length = n.norm();
    n = length > 0 ? Eigen::Vector3f(n / length) : Eigen::Vector3f(Eigen::Vector3f::Zero());
  }
  return normals;
}

}  // namespace livemvs
