#include "livemvs/io/dataset_check.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"

namespace livemvs {
namespace {

constexpr double kMaxRotationError = 1e-2;       // of RᵀR - I, beyond any rounding of text
constexpr double kMaxQuaternionRounding = 1e-3;  // of the norm: more is worth a warning
constexpr double kMaxQuaternionError = 0.1;      // of the norm: more is no quaternion

}  // namespace

Eigen::Matrix3d PoseChecker::FromMatrix(const Eigen::Matrix3d& matrix,
                                        const std::string& place) const {
  const double error =
      (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kMaxRotationError)) {
    throw BadInput(place + ": not a rotation (R'R differs from the identity by " +
                   std::to_string(error) + "); are rows, columns and their order as documented?");
  }
  if (!(matrix.determinant() > 0)) {
    throw BadInput(place +
                   ": the rotation is a mirror image (negative determinant); flip two axes "
                   "or none, see the conventions in docs/data-formats.md");
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::Matrix3d PoseChecker::FromQuaternion(
    double w, double x, double y, double z, const std::string& place) {
  const Eigen::Quaterniond q(w, x, y, z);
  const double error = std::abs(q.norm() - 1);
  if (!(error <= kMaxQuaternionError)) {
    throw BadInput(place + ": the quaternion's norm is " + std::to_string(q.norm()) +
                   ", not 1; is the order of the columns as documented?");
  }
  if (error > kMaxQuaternionRounding && !warned_) {
    warned_ = true;
    LogWarning(place + ": the quaternion's norm is " + std::to_string(q.norm()) +
               ", not 1; this one and any like it are normalised");
  }
  return q.normalized().toRotationMatrix();
}

Camera CheckedCamera(Camera camera, const std::string& place) {
  Camera checked = camera;
  if (checked.width == 0 && checked.height == 0) checked.width = checked.height = 1;
  try {
    checked.Check();
  } catch (const std::invalid_argument& e) {
    throw BadInput(place + ": " + e.what());
  }
  const bool distorted = std::any_of(
      camera.distortion.begin(), camera.distortion.end(), [](double k) { return k != 0; });
  if (!distorted && camera.model == CameraModel::kBrownConrady) {
    camera.model = CameraModel::kPinhole;
  }
  return camera;
}

Rigid3d FromOpenGl(const Rigid3d& world_from_gl_cam) {
  Rigid3d world_from_cam = world_from_gl_cam;
  world_from_cam.rotation.col(1) *= -1;
  world_from_cam.rotation.col(2) *= -1;
  return world_from_cam.Inverse();
}

Camera CameraForSize(const Camera& camera, int width, int height, const std::string& picture) {
  Camera sized = camera;
  if (sized.width == 0 && sized.height == 0) {
    sized.width = width;
    sized.height = height;
  }
  if (sized.width == width && sized.height == height) return sized;
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  throw BadInput(
      picture + ": the picture has " + size(width, height) +
      " pixels, but the calibration is for " + size(sized.width, sized.height) +
      "; use the pictures that were calibrated, or calibrate again (scaled pictures need "
      "scaled fx, fy, cx, cy)");
}

std::filesystem::path ResolveInside(const std::filesystem::path& root,
                                    const std::string& name,
                                    const std::string& place) {
  namespace fs = std::filesystem;
  const auto climbs = [&](const std::string& why) {
    return BadInput(place + ": the image path '" + name.substr(0, 200) + "' " + why +
                    "; images must lie in the data set's folder (or name theirs with --images)");
  };
  const fs::path relative(name);
  if (name.empty()) throw BadInput(place + ": the image path is empty");
  if (name.find('\0') != std::string::npos) throw climbs("holds a zero byte");
  if (relative.is_absolute()) throw climbs("is absolute");
  std::error_code error;
  fs::path base = fs::weakly_canonical(root, error);
  if (base.has_relative_path() && base.filename().empty()) base = base.parent_path();
  if (error) throw BadInput(root.string() + ": cannot be resolved: " + error.message());
  const fs::path resolved = fs::weakly_canonical(base / relative, error);
  if (error) throw climbs("cannot be resolved (" + error.message() + ")");
  const auto [end, unused] =
      std::mismatch(base.begin(), base.end(), resolved.begin(), resolved.end());
  if (end != base.end()) throw climbs("leaves the data set's folder");
  return resolved;
}

}  // namespace livemvs
