#include "livemvs/core/camera.h"

#include <Eigen/LU>
#include <stdexcept>

namespace livemvs {
namespace {

// Rays further off the axis are not used: their texture is smeared and seeds keep (X / Z, Y / Z).
constexpr double kMaxRadius2 = 32.16;  // tan² 80°

template <typename Model>
DistortedPoint<double> DistortWith(Model, const Camera& camera, double x, double y) {
  return Model::Distort(camera.distortion.data(), x, y);
}

DistortedPoint<double> Distort(const Camera& camera, double x, double y) {
  return VisitModel(camera.model, [&](auto model) { return DistortWith(model, camera, x, y); });
}

void CheckFinite(double value, const char* name) {
  if (!std::isfinite(value)) {
    throw std::invalid_argument(std::string("camera: ") + name + " is not finite");
  }
}

}  // namespace

Camera AtLevel(const Camera& camera, int level) {
  Camera smaller = camera;
  const double scale = std::ldexp(1.0, -level);
  smaller.width = camera.width >> level;
  smaller.height = camera.height >> level;
  smaller.fx *= scale;
  smaller.fy *= scale;
  smaller.cx = (camera.cx + 0.5) * scale - 0.5;
  smaller.cy = (camera.cy + 0.5) * scale - 0.5;
  return smaller;
}

void Camera::Check() const {
  if (width < 1 || height < 1 || width > 32768 || height > 32768) {
    throw std::invalid_argument("camera: image size " + std::to_string(width) + " x " +
                                std::to_string(height) + " is not within 1 ... 32768");
  }
  CheckFinite(fx, "fx");
  CheckFinite(fy, "fy");
  CheckFinite(cx, "cx");
  CheckFinite(cy, "cy");
  for (const double k : distortion) CheckFinite(k, "a distortion coefficient");
  if (!(fx > 0) || fy == 0) {
    throw std::invalid_argument("camera: focal lengths fx = " + std::to_string(fx) + ", fy = " +
                                std::to_string(fy) + "; fx must be positive and fy not zero");
  }
}

double MaxValidRadius2(const Camera& camera) {
  if (camera.model == CameraModel::kPinhole) return kMaxRadius2;
  // March outwards along both diagonals' worst case: the radial derivative must stay positive.
  const double r_max = std::sqrt(kMaxRadius2);
  constexpr int kSteps = 500;
  double valid = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = r_max * i / kSteps;
    for (int direction = 0; direction < 8; ++direction) {
      const double angle = direction * (M_PI / 4);
      const double ux = std::cos(angle), uy = std::sin(angle);
      const DistortedPoint<double> p = Distort(camera, r * ux, r * uy);
      const double radial = ux * (p.xx * ux + p.xy * uy) + uy * (p.yx * ux + p.yy * uy);
      if (!(radial > 0.05) || !(p.xx * p.yy - p.xy * p.yx > 0)) {
        // Kannala-Brandt flattens far out by nature (atan); only a fold ends its range.
        if (camera.model != CameraModel::kKannalaBrandt || !(radial > 0)) return valid * valid;
      }
    }
    valid = r;
  }
  return valid * valid;
}

std::optional<Eigen::Vector2d> Projector::Project(const Eigen::Vector3d& point_in_cam) const {
  if (!(point_in_cam.z() > 0)) return std::nullopt;
  const double x = point_in_cam.x() / point_in_cam.z();
  const double y = point_in_cam.y() / point_in_cam.z();
  if (!(x * x + y * y <= params_.r2_max)) return std::nullopt;
  const DistortedPoint<double> p = Distort(camera_, x, y);
  return Eigen::Vector2d(camera_.fx * p.x + camera_.cx, camera_.fy * p.y + camera_.cy);
}

std::optional<Eigen::Vector3d> Projector::Unproject(const Eigen::Vector2d& pixel) const {
  return VisitModel(camera_.model, [&](auto model) -> std::optional<Eigen::Vector3d> {
    double x = 0, y = 0;
    if (!UnprojectPixel<decltype(model)>(params_, pixel.x(), pixel.y(), &x, &y)) return {};
    return Eigen::Vector3d(x, y, 1);
  });
}

Eigen::Matrix2d BearingPerPixel(const Camera& camera, double x, double y) {
  const auto lens = VisitModel(camera.model, [&](auto model) {
    return decltype(model)::template Distort<double>(camera.distortion.data(), x, y);
  });
  Eigen::Matrix2d pixel_per_bearing;
  pixel_per_bearing << camera.fx * lens.xx, camera.fx * lens.xy, camera.fy * lens.yx,
      camera.fy * lens.yy;
  return pixel_per_bearing.inverse();
}

std::string ToString(CameraModel model) {
  switch (model) {
    case CameraModel::kBrownConrady:
      return "Brown-Conrady";
    case CameraModel::kKannalaBrandt:
      return "Kannala-Brandt";
    case CameraModel::kPinhole:
      break;
  }
  return "pinhole";
}

}  // namespace livemvs
