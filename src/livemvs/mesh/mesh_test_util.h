#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "livemvs/core/mesh.h"
#include "livemvs/core/point.h"
#include "livemvs/mesh/build_mesh.h"
#include "livemvs/mesh/mesh_topology.h"

namespace livemvs {

/// A camera at `center` that looks at `target`.
inline PosedCamera LookAt(const Eigen::Vector3d& center, const Eigen::Vector3d& target) {
  PosedCamera c;
  c.camera.width = 640;
  c.camera.height = 480;
  c.camera.fx = c.camera.fy = 500;
  c.camera.cx = 319.5;
  c.camera.cy = 239.5;
  const Eigen::Vector3d z = (target - center).normalized();
  const Eigen::Vector3d x = z.unitOrthogonal(), y = z.cross(x);
  c.cam_from_world.rotation << x.transpose(), y.transpose(), z.transpose();
  c.cam_from_world.translation = -c.cam_from_world.rotation * center;
  return c;
}

/// Points of surfaces, seen by cameras, with noise along the line of sight.
class CloudMaker {
 public:
  explicit CloudMaker(double sigma) : sigma_(sigma) {}

  std::int32_t AddCamera(const Eigen::Vector3d& center, const Eigen::Vector3d& target) {
    const auto index = static_cast<std::int32_t>(cameras_.size());
    cameras_[index] = LookAt(center, target);
    return index;
  }

  void AddPoint(const Eigen::Vector3d& on_surface,
                const Eigen::Vector3d& normal,
                std::int32_t frame) {
    const Eigen::Vector3d to_camera =
        (cameras_.at(frame).cam_from_world.Center() - on_surface).normalized();
    Point p;
    p.position = (on_surface + sigma_ * normal_(random_) * to_camera).cast<float>();
    p.normal = normal.cast<float>();
    p.color = {200, 100, 50};
    p.sigma = static_cast<float>(sigma_);
    p.inlier_ratio = 0.9F;
    p.frame = frame;
    cloud_.push_back(p);
  }

  /// Points all over a sphere, each seen by the camera that faces it most.
  void AddSphere(const Eigen::Vector3d& center, double radius, int count) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d n =
          Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_)).normalized();
      std::int32_t best = 0;
      double most = -2;
      for (const auto& [index, c] : cameras_) {
        const double facing = n.dot((c.cam_from_world.Center() - center).normalized());
        if (facing > most) {
          most = facing;
          best = static_cast<std::int32_t>(index);
        }
      }
      AddPoint(center + radius * n, n, best);
    }
  }

  std::mt19937& random() { return random_; }
  double Uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random_);
  }
  PointCloud& cloud() { return cloud_; }
  const MeshCameras& cameras() const { return cameras_; }

 private:
  double sigma_;
  std::mt19937 random_{7};
  std::normal_distribution<double> normal_;
  PointCloud cloud_;
  MeshCameras cameras_;
};

/// Cameras all about the origin.
inline void AddCamerasAround(double distance, CloudMaker* maker) {
  for (const double z : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double x : {-1.0, 1.0}) {
        maker->AddCamera(distance * Eigen::Vector3d(x, y, z).normalized(), Eigen::Vector3d::Zero());
      }
    }
  }
}

/// Six times the volume a mesh encloses; > 0 where its faces are counter-clockwise from outside.
inline double SignedVolume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3i& f : mesh.faces) {
    const auto corner = [&](int k) -> Eigen::Vector3d {
      return mesh.vertices[static_cast<std::size_t>(f[k])].cast<double>();
    };
    sum += corner(0).dot(corner(1).cross(corner(2)));
  }
  return sum;
}

}  // namespace livemvs
