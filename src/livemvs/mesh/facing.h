#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/core/posed_camera.h"
#include "livemvs/eval/surface.h"
#include "livemvs/mesh/mesh_camera.h"

namespace livemvs {

/// A camera that is asked what it sees of a surface.
class SurfaceViewer {
 public:
  /// @param border_px  Not so close to its picture's edge. [px]
  SurfaceViewer(const PosedCamera& camera, double border_px);

  struct Sighting {
    float facing;           ///< Cosine between the normal and the direction to the camera.
    float length;           ///< From the camera. [scene]
    Eigen::Vector2d pixel;  ///< Where in its picture. [px]
  };

  /// How it sees a vertex with a unit normal; nothing where the cosine is not above `least_facing`,
  /// the vertex is not in the picture, or a part of the surface hides it that is more than
  /// `thickness` before it [scene]. Thread-safe.
  std::optional<Sighting> See(const Eigen::Vector3f& vertex,
                              const Eigen::Vector3f& normal,
                              float least_facing,
                              const MeshSurface& surface,
                              float thickness) const;

 private:
  Projector projector_;
  Rigid3d cam_from_world_;
  Eigen::Vector3f center_;
  double border_px_;
};

/// How frontally each of some vertices was seen: the second largest cosine, over cameras that see
/// the vertex with nothing of the mesh in between, of the angle between the surface's normal and
/// the direction to the camera; 0 where fewer than two see it, or it is not asked for. Surface that
/// the cut drew along the limit of what was seen is seen from its side only.
/// @param asked     One for each vertex: whether it is asked for.
/// @param farthest  A surface this close to the vertex does not hide it. [scene]
/// Multi-threaded; deterministic.
std::vector<float> FacingOfVertices(const TriangleMesh& mesh,
                                    const MeshCameras& cameras,
                                    const std::vector<char>& asked,
                                    double farthest);

/// Unit normals of vertices: of the faces about them, by area; zero where there are none.
std::vector<Eigen::Vector3f> VertexNormals(const TriangleMesh& mesh);

}  // namespace livemvs
