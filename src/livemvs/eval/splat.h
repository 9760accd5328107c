#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "livemvs/core/point.h"
#include "livemvs/eval/surface.h"
#include "livemvs/eval/view.h"

namespace livemvs {

/// What a pixel shows before light falls on it.
struct Fragment {
  float depth = std::numeric_limits<float>::infinity();  ///< z in camera axes; infinite: nothing.
  Eigen::Vector3f color = Eigen::Vector3f::Zero();       ///< Linear light, in [0, 1].
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();      ///< In camera axes; zero: unknown.
};

/// A picture of fragments, row-major.
struct FragmentImage {
  int width = 0;
  int height = 0;
  std::vector<Fragment> fragments;

  Fragment& At(int x, int y) { return fragments[static_cast<std::size_t>(y) * width + x]; }
  const Fragment& At(int x, int y) const {
    return fragments[static_cast<std::size_t>(y) * width + x];
  }
};

/// A point as it is drawn.
struct Splat {
  Eigen::Vector3f position;  ///< In the world.
  Eigen::Vector3f normal;    ///< In the world; zero: unknown.
  Eigen::Vector3f color;     ///< Linear light.
  float radius;              ///< [scene]
};

/// Draws discs that face the viewer; where discs of one surface overlap, colours and normals are
/// blended. `scale` times as many pixels each way as the view's camera has. Deterministic;
/// multi-threaded.
FragmentImage DrawSplats(const std::vector<Splat>& splats, const RenderView& view, int scale);

/// Draws the surface, with a colour per vertex of the mesh it was made from. (linear light)
FragmentImage DrawMesh(const TriangleMesh& mesh,
                       const std::vector<Eigen::Vector3f>& vertex_colors,
                       const RenderView& view,
                       int scale);

}  // namespace livemvs
