#pragma once

#include <Eigen/Core>

namespace livemvs {

/// A rigid motion b_from_a: point_in_b = rotation * point_in_a + translation. [scene units]
/// Poses of cameras are cam_from_world; camera axes are x right, y down, z forward.
struct Rigid3d {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  /// a_from_b of b_from_a.
  Rigid3d Inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }

  /// The origin of b, in a: of cam_from_world, the camera's centre in the world.
  Eigen::Vector3d Center() const { return -(rotation.transpose() * translation); }
};

/// c_from_a = c_from_b * b_from_a.
inline Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation,
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

inline Eigen::Vector3d operator*(const Rigid3d& b_from_a, const Eigen::Vector3d& point_in_a) {
  return b_from_a.rotation * point_in_a + b_from_a.translation;
}

}  // namespace livemvs
