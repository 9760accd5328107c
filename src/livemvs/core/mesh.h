#pragma once

#include <Eigen/Core>
#include <vector>

#include "livemvs/core/frame.h"

namespace livemvs {

/// A surface of triangles. [scene]
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> faces;  ///< Indices of vertices, counter-clockwise from outside.
  std::vector<Rgb> colors;             ///< One per vertex, or empty.
};

}  // namespace livemvs
