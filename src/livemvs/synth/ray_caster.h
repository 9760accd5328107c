#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "livemvs/synth/scene_mesh.h"

namespace livemvs::synth {

/// Triangles prepared for ray queries. Queries may come from several threads at once.
class RayCaster {
 public:
  explicit RayCaster(const SceneMesh& mesh);
  ~RayCaster();

  struct Hit {
    float distance, u, v;
    int face;
  };
  bool Intersect(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, Hit* hit) const;

  /// Casts neighbouring rays together, which is faster. Where nothing is hit, face is -1.
  struct Ray {
    Eigen::Vector3f origin, direction;
  };
  void Intersect(std::span<const Ray> rays, std::span<Hit> hits) const;

  /// Whether anything lies on the ray nearer than `distance` times the direction's length.
  bool Occluded(const Eigen::Vector3f& origin,
                const Eigen::Vector3f& direction,
                float distance) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livemvs::synth
