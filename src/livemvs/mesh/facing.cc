#include "livemvs/mesh/facing.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "livemvs/eval/surface.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// Cameras that are asked, at most.
constexpr std::size_t kMostCameras = 48;

/// Some of the cameras, evenly along the film.
std::vector<SurfaceViewer> ChooseViewers(const MeshCameras& cameras) {
  std::vector<SurfaceViewer> viewers;
  const std::size_t count = std::min(kMostCameras, cameras.size());
  std::size_t i = 0, next = 0;
  for (const auto& [index, c] : cameras) {
    if (i++ != next * cameras.size() / count) continue;
    ++next;
    viewers.emplace_back(c, 0);
  }
  return viewers;
}

float FacingOf(const Eigen::Vector3f& vertex,
               const Eigen::Vector3f& normal,
               const std::vector<SurfaceViewer>& viewers,
               const MeshSurface& surface,
               float farthest) {
  float best = 0, second = 0;
  for (const SurfaceViewer& viewer : viewers) {
    const auto sighting = viewer.See(vertex, normal, second, surface, farthest);
    if (!sighting) continue;
    second = std::min(best, sighting->facing);
    best = std::max(best, sighting->facing);
  }
  return second;
}

}  // namespace

SurfaceViewer::SurfaceViewer(const PosedCamera& camera, double border_px)
    : projector_(camera.camera),
      cam_from_world_(camera.cam_from_world),
      center_(camera.cam_from_world.Center().cast<float>()),
      border_px_(border_px) {}

std::optional<SurfaceViewer::Sighting> SurfaceViewer::See(const Eigen::Vector3f& vertex,
                                                          const Eigen::Vector3f& normal,
                                                          float least_facing,
                                                          const MeshSurface& surface,
                                                          float thickness) const {
  const Eigen::Vector3f to_vertex = vertex - center_;
  const float length = to_vertex.norm();
  const float facing = -normal.dot(to_vertex) / length;
  if (!(facing > least_facing)) return std::nullopt;
  const auto pixel = projector_.Project(cam_from_world_ * vertex.cast<double>());
  if (!pixel || !projector_.camera().Contains(*pixel, border_px_)) return std::nullopt;
  if (surface.IsBlocked(center_, to_vertex, 1 - std::min(thickness / length, 1.0F))) {
    return std::nullopt;
  }
  return Sighting{facing, length, *pixel};
}

std::vector<float> FacingOfVertices(const TriangleMesh& mesh,
                                    const MeshCameras& cameras,
                                    const std::vector<char>& asked,
                                    double farthest) {
  std::vector<float> facing(mesh.vertices.size(), 0);
  if (mesh.faces.empty() || cameras.empty()) return facing;
  const std::vector<SurfaceViewer> viewers = ChooseViewers(cameras);
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
