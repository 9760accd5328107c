#pragma once

#include <vector>

#include "livemvs/core/mesh.h"
#include "livemvs/mesh/mesh_camera.h"

namespace livemvs {

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
