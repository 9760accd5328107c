#pragma once

#include <Eigen/Core>

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// Number of intrinsics: fx fy cx cy and eight of the distortion (Camera's order).
inline constexpr int kIntrinsics = 12;

/// A projected point with its derivatives.
struct PointProjection {
  Eigen::Vector2d pixel;                            ///< [px]
  Eigen::Matrix<double, 2, 3> by_point;             ///< d pixel / d point_in_cam
  Eigen::Matrix<double, 2, kIntrinsics> by_camera;  ///< d pixel / d intrinsics
};

/// Projects a point in front of the camera (z > 0) without asking whether the distortion is
/// one-to-one there. `by_camera` is filled where `with_camera` is set.
PointProjection ProjectWithDerivatives(const Camera& camera,
                                       const Eigen::Vector3d& point_in_cam,
                                       bool with_camera);

/// The pose moved by a small motion in camera axes, (rotation vector [rad], translation [m]):
/// point_in_cam becomes exp(rotation) point_in_cam + translation.
Rigid3d Moved(const Rigid3d& cam_from_world, const Eigen::Matrix<double, 6, 1>& motion);

/// Derivative of a projected point by such a motion, at zero.
Eigen::Matrix<double, 2, 6> ByMotion(const PointProjection& projection,
                                     const Eigen::Vector3d& point_in_cam);

}  // namespace livemvs
