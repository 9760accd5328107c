#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "livemvs/core/platform.h"

namespace livemvs {

/// How a ray (x, y, 1) in camera axes bends before the focal lengths apply.
enum class CameraModel {
  kPinhole,        ///< No distortion.
  kBrownConrady,   ///< OpenCV's model: k1 k2 p1 p2 k3, with k4 k5 k6 the rational one.
  kKannalaBrandt,  ///< OpenCV's fisheye: k1 k2 k3 k4 on the angle to the axis.
};

/// Intrinsics of a camera: pixel = (fx, fy) * distort(X / Z, Y / Z) + (cx, cy).
/// Pixel centres are integers: (0, 0) is the centre of the top-left pixel. fy may be negative (some
/// data sets have the image upside down); fx and fy are otherwise free of constraints but zero.
struct Camera {
  CameraModel model = CameraModel::kPinhole;
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  double fx = 0;   ///< [px]
  double fy = 0;   ///< [px]
  double cx = 0;   ///< [px]
  double cy = 0;   ///< [px]
  /// kBrownConrady: k1 k2 p1 p2 k3 k4 k5 k6 (OpenCV's order); kKannalaBrandt: k1 k2 k3 k4.
  std::array<double, 8> distortion{};

  /// @throws std::invalid_argument naming the field, where the intrinsics are not finite, zero
  /// focal lengths, or an empty image.
  void Check() const;

  /// Mean of the two focal lengths [px].
  double FocalLength() const { return std::sqrt(std::abs(fx * fy)); }

  bool Contains(const Eigen::Vector2d& pixel, double border = 0) const {
    return pixel.x() >= border && pixel.y() >= border && pixel.x() <= width - 1 - border &&
           pixel.y() <= height - 1 - border;
  }
};

/// The camera of the image halved `level` times: a pixel of it is the mean of a square of
/// 2^level pixels, whose centre lies between theirs. An odd last row or column is lost.
Camera AtLevel(const Camera& camera, int level);

/// A distorted point and the derivative of the distortion there.
template <typename T>
struct DistortedPoint {
  T x, y;            ///< Distorted coordinates.
  T xx, xy, yx, yy;  ///< d(x, y) / d(undistorted x, y), row-major.
};

/// Intrinsics as kernels take them: trivially copyable, in one floating-point type.
template <typename T>
struct CameraParams {
  T fx, fy, cx, cy;
  T k[8];
  T r2_max;  ///< Largest squared radius (X² + Y²) / Z² on which the distortion is one-to-one.
};

/// The three models as stateless functors on (x, y) = (X / Z, Y / Z), Z > 0, so that a loop over
/// seeds is compiled once for each.
struct PinholeModel {
  static constexpr CameraModel kModel = CameraModel::kPinhole;
  template <typename T, typename S>
  LIVEMVS_HD static DistortedPoint<T> Distort(const S*, T x, T y) {
    return {x, y, T(1), T(0), T(0), T(1)};
  }
};

struct BrownConradyModel {
  static constexpr CameraModel kModel = CameraModel::kBrownConrady;
  /// x' = x a/b + 2 p1 x y + p2 (r² + 2 x²), y' = y a/b + p1 (r² + 2 y²) + 2 p2 x y,
  /// a = 1 + k1 r² + k2 r⁴ + k3 r⁶, b = 1 + k4 r² + k5 r⁴ + k6 r⁶.
  template <typename T, typename S>
  LIVEMVS_HD static DistortedPoint<T> Distort(const S* k, T x, T y) {
    const T k1(k[0]), k2(k[1]), p1(k[2]), p2(k[3]), k3(k[4]), k4(k[5]), k5(k[6]), k6(k[7]);
    const T r2 = x * x + y * y;
    const T a = T(1) + r2 * (k1 + r2 * (k2 + r2 * k3));
    const T b = T(1) + r2 * (k4 + r2 * (k5 + r2 * k6));
    const T da = k1 + r2 * (T(2) * k2 + r2 * T(3) * k3);  // da / d(r²)
    const T db = k4 + r2 * (T(2) * k5 + r2 * T(3) * k6);
    const T radial = a / b;
    const T d_radial = T(2) * (da - radial * db) / b;  // d radial / dx = d_radial * x
    DistortedPoint<T> p;
    p.x = x * radial + T(2) * p1 * x * y + p2 * (r2 + T(2) * x * x);
    p.y = y * radial + p1 * (r2 + T(2) * y * y) + T(2) * p2 * x * y;
    p.xx = radial + x * x * d_radial + T(2) * p1 * y + T(6) * p2 * x;
    p.xy = x * y * d_radial + T(2) * p1 * x + T(2) * p2 * y;
    p.yx = p.xy;
    p.yy = radial + y * y * d_radial + T(6) * p1 * y + T(2) * p2 * x;
    return p;
  }
};

struct KannalaBrandtModel {
  static constexpr CameraModel kModel = CameraModel::kKannalaBrandt;
  /// θ = atan r, θ_d = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), (x', y') = θ_d / r (x, y).
  template <typename T, typename S>
  LIVEMVS_HD static DistortedPoint<T> Distort(const S* k, T x, T y) {
    const T r2 = x * x + y * y;
    // Below this the series θ_d / r = 1 + (k1 - 1/3) r² is exact to the type's precision.
    const T k1(k[0]), k2(k[1]), k3(k[2]), k4(k[3]);
    const MaskOf<T> small = r2 < T(1e-8);
    const T far_r2 = Select(small, T(1), r2);
    const T r = Sqrt(far_r2);
    const T theta = Atan(r);
    const T t2 = theta * theta;
    const T poly = T(1) + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)));
    const T d_poly =
        T(1) + t2 * (T(3) * k1 + t2 * (T(5) * k2 + t2 * (T(7) * k3 + t2 * (T(9) * k4))));
    const T scale_far = theta * poly / r;
    const T near_axis = k1 - T(1) / T(3);
    const T scale = Select(small, T(1) + near_axis * r2, scale_far);
    // d scale / dx = d_scale * x
    const T d_scale =
        Select(small, T(2) * near_axis, (d_poly / (T(1) + far_r2) - scale_far) / far_r2);
    return {x * scale,
            y * scale,
            scale + x * x * d_scale,
            x * y * d_scale,
            x * y * d_scale,
            scale + y * y * d_scale};
  }
};

/// Calls `f` with the functor of a model, so that choices are made once per batch of seeds.
template <typename F>
decltype(auto) VisitModel(CameraModel model, F&& f) {
  switch (model) {
    case CameraModel::kBrownConrady:
      return f(BrownConradyModel{});
    case CameraModel::kKannalaBrandt:
      return f(KannalaBrandtModel{});
    case CameraModel::kPinhole:
      break;
  }
  return f(PinholeModel{});
}

/// The largest squared radius (X² + Y²) / Z² up to which the camera's distortion is one-to-one, at
/// most that of a ray 80° off the axis.
double MaxValidRadius2(const Camera& camera);

template <typename T>
CameraParams<T> MakeCameraParams(const Camera& camera) {
  CameraParams<T> p;
  p.fx = static_cast<T>(camera.fx);
  p.fy = static_cast<T>(camera.fy);
  p.cx = static_cast<T>(camera.cx);
  p.cy = static_cast<T>(camera.cy);
  for (int i = 0; i < 8; ++i) p.k[i] = static_cast<T>(camera.distortion[i]);
  p.r2_max = static_cast<T>(MaxValidRadius2(camera));
  return p;
}

/// The ray (x, y, 1) through the pixel (u, v); false where no ray of the model's valid range maps
/// there. Newton's method on the distortion: accurate to 1e-9 of the focal length.
template <typename Model>
LIVEMVS_DEVICE bool UnprojectPixel(
    const CameraParams<double>& camera, double u, double v, double* x, double* y) {
  const double xd = (u - camera.cx) / camera.fx;
  const double yd = (v - camera.cy) / camera.fy;
  if (!std::isfinite(xd) || !std::isfinite(yd)) return false;
  *x = xd;
  *y = yd;
  if constexpr (Model::kModel == CameraModel::kKannalaBrandt) {
    // Start from the undistorted fisheye, whose radius is the angle itself.
    const double radius = std::hypot(xd, yd);
    const double theta = std::min(radius, 1.39);
    const double scale = theta > 1e-9 ? std::tan(theta) / radius : 1;
    *x *= scale;
    *y *= scale;
  }
  constexpr int kIterations = 50;
  constexpr double kTolerance = 1e-10;
  for (int i = 0; i < kIterations; ++i) {
    const double r2 = *x * *x + *y * *y;
    if (r2 > camera.r2_max) {  // back to the valid disc: the solution lies in it or nowhere
      const double shrink = std::sqrt(camera.r2_max / r2);
      *x *= shrink;
      *y *= shrink;
    }
    const DistortedPoint<double> p = Model::Distort(camera.k, *x, *y);
    const double ex = xd - p.x, ey = yd - p.y;
    if (std::abs(ex) < kTolerance && std::abs(ey) < kTolerance) return true;
    const double det = p.xx * p.yy - p.xy * p.yx;
    if (!(std::abs(det) > 1e-12)) return false;
    *x += (p.yy * ex - p.xy * ey) / det;
    *y += (p.xx * ey - p.yx * ex) / det;
  }
  return false;
}

/// Maps points to pixels and pixels to rays, in double. Make one per camera and keep it: the
/// constructor finds the valid range of the distortion.
class Projector {
 public:
  explicit Projector(const Camera& camera)
      : camera_(camera), params_(MakeCameraParams<double>(camera)) {}

  const Camera& camera() const { return camera_; }

  /// The pixel of a point in camera axes, or nothing where the point is behind the camera or beyond
  /// the angle up to which the distortion is one-to-one. The pixel may lie outside of the image.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_cam) const;

  /// The ray (X / Z, Y / Z, 1) through a pixel, or nothing; see UnprojectPixel().
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const;

 private:
  Camera camera_;
  CameraParams<double> params_;
};

/// How the ray (x, y, 1) changes with its pixel: d(x, y) / d(u, v). [1/px] Not finite where the
/// distortion folds.
Eigen::Matrix2d BearingPerPixel(const Camera& camera, double x, double y);

/// For messages: "pinhole", "Brown-Conrady", "Kannala-Brandt".
std::string ToString(CameraModel model);

}  // namespace livemvs
