#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// Turns the rotations of one file into exact ones, or refuses them. Places are "file:line".
class PoseChecker {
 public:
  /// A rotation matrix as written. Small deviations (rounding) are taken away by the nearest
  /// rotation.
  /// @throws Error (kBadInput) where |RᵀR - I| > 1e-2 in any entry, or the determinant is negative.
  Eigen::Matrix3d FromMatrix(const Eigen::Matrix3d& matrix, const std::string& place) const;

  /// A Hamilton quaternion. A norm off by more than 1e-3 is warned of, once for each checker.
  /// @throws Error (kBadInput) where the norm is off by more than 0.1.
  Eigen::Matrix3d FromQuaternion(double w, double x, double y, double z, const std::string& place);

 private:
  bool warned_ = false;
};

/// Camera::Check with the place in front, and a camera whose distortion is all zero made a pinhole.
/// The image size may still be unknown (0 x 0).
/// @throws Error (kBadInput).
Camera CheckedCamera(Camera camera, const std::string& place);

/// cam_from_world in our axes from world_from_cam in OpenGL's (x right, y up, z backward).
Rigid3d FromOpenGl(const Rigid3d& world_from_gl_cam);

/// The camera for pictures of this size.
/// @throws Error (kBadInput) naming both sizes and the remedy, where the calibration states
/// another.
Camera CameraForSize(const Camera& camera, int width, int height, const std::string& picture);

/// `root / name`, where that stays below `root` when links are followed.
/// @throws Error (kBadInput) where the path climbs out of the folder or is absolute.
std::filesystem::path ResolveInside(const std::filesystem::path& root,
                                    const std::string& name,
                                    const std::string& place);

}  // namespace livemvs
