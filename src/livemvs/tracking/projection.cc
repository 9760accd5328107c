#include "livemvs/tracking/projection.h"

#include <Eigen/Geometry>
#include <cmath>

namespace livemvs {
namespace {

using ByCamera = Eigen::Matrix<double, 2, kIntrinsics>;

// d (x', y') / d k of the Brown-Conrady model, times the focal lengths.
void AddBrownConrady(const Camera& c, double x, double y, ByCamera* by) {
  const auto& k = c.distortion;
  const double r2 = x * x + y * y;
  const double a = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double b = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const double numerator[3] = {r2 / b, r2 * r2 / b, r2 * r2 * r2 / b};
  constexpr int kNumerator[3] = {4, 5, 8}, kDenominator[3] = {9, 10, 11};
  for (int i = 0; i < 3; ++i) {
    by->col(kNumerator[i]) << c.fx * x * numerator[i], c.fy * y * numerator[i];
    by->col(kDenominator[i]) << -c.fx * x * numerator[i] * a / b, -c.fy * y * numerator[i] * a / b;
  }
  by->col(6) << c.fx * 2 * x * y, c.fy * (r2 + 2 * y * y);
  by->col(7) << c.fx * (r2 + 2 * x * x), c.fy * 2 * x * y;
}

// Likewise of the Kannala-Brandt model.
void AddKannalaBrandt(const Camera& c, double x, double y, ByCamera* by) {
  const double r = std::hypot(x, y), theta = std::atan(r);
  const double scale = r > 1e-8 ? theta / r : 1;
  double power = scale * theta * theta;
  for (int i = 0; i < 4; ++i, power *= theta * theta) {
    by->col(4 + i) << c.fx * x * power, c.fy * y * power;
  }
}

}  // namespace

PointProjection ProjectWithDerivatives(const Camera& c,
                                       const Eigen::Vector3d& p,
                                       bool with_camera) {
  const double iz = 1 / p.z(), x = p.x() * iz, y = p.y() * iz;
  const DistortedPoint<double> d = VisitModel(c.model, [&](auto model) {
    return decltype(model)::template Distort<double>(c.distortion.data(), x, y);
  });
  PointProjection out;
  out.pixel = {c.fx * d.x + c.cx, c.fy * d.y + c.cy};
  out.by_point << c.fx * d.xx * iz, c.fx * d.xy * iz, -c.fx * (d.xx * x + d.xy * y) * iz,  //
      c.fy * d.yx * iz, c.fy * d.yy * iz, -c.fy * (d.yx * x + d.yy * y) * iz;
  if (!with_camera) return out;
  out.by_camera.setZero();
  out.by_camera(0, 0) = d.x;
  out.by_camera(1, 1) = d.y;
  out.by_camera(0, 2) = out.by_camera(1, 3) = 1;
  if (c.model == CameraModel::kBrownConrady) AddBrownConrady(c, x, y, &out.by_camera);
  if (c.model == CameraModel::kKannalaBrandt) AddKannalaBrandt(c, x, y, &out.by_camera);
  return out;
}

Rigid3d Moved(const Rigid3d& cam_from_world, const Eigen::Matrix<double, 6, 1>& motion) {
  const Eigen::Vector3d w = motion.head<3>();
  const double angle = w.norm();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (angle > 0) turn = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  // Through a unit quaternion, so that rounding does not add up over the frames.
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(turn * cam_from_world.rotation).normalized();
  return {rotation.toRotationMatrix(), turn * cam_from_world.translation + motion.tail<3>()};
}

Eigen::Matrix<double, 2, 6> ByMotion(const PointProjection& projection, const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 6> by_motion;
  by_motion << 0, p.z(), -p.y(), 1, 0, 0,  //
      -p.z(), 0, p.x(), 0, 1, 0,           //
      p.y(), -p.x(), 0, 0, 0, 1;
  return projection.by_point * by_motion;
}

}  // namespace livemvs
