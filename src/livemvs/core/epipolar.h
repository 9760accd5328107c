#pragma once

#include <cmath>
#include <cstdint>

#include "livemvs/core/camera.h"
#include "livemvs/core/options.h"
#include "livemvs/core/platform.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// What one frame told about one seed. Only a mismatch counts against it.
enum class MatchStatus : std::uint8_t {
  kMatched,
  kNoInformation,  ///< No baseline, flat along the line, or ambiguous.
  kOutOfView,      ///< Behind the camera, outside of the image or of the lens model's range.
  kMismatch        ///< In view, and nothing on the line looks like the patch.
};

/// The part of a ray on which a seed's surface is sought, as coordinates (Z or 1 / Z) of mu = 0
/// and 1.
template <typename T>
struct Interval {
  T c0;
  T c1;
};

/// Everything that the seeds of one reference frame share when they meet the current frame.
template <typename T>
struct RelativeView {
  T r[9];  ///< cur_from_ref, row-major.
  T t[3];
  CameraParams<T> camera;  ///< Of the current frame.
  T width, height;         ///< [px] of the current frame.
  T roll_cos, roll_sin;    ///< Rotation of the picture, current from reference.
  T focal_ratio;           ///< Focal length of the current over that of the reference frame.
};

/// @param cur_params  MakeCameraParams() of `cur`, which is worth making once for all reference
/// frames.
template <typename T>
RelativeView<T> MakeRelativeView(const Camera& ref,
                                 const Rigid3d& ref_from_world,
                                 const Camera& cur,
                                 const CameraParams<T>& cur_params,
                                 const Rigid3d& cur_from_world);

template <typename T>
RelativeView<T> MakeRelativeView(const Camera& ref,
                                 const Rigid3d& ref_from_world,
                                 const Camera& cur,
                                 const Rigid3d& cur_from_world) {
  return MakeRelativeView(ref, ref_from_world, cur, MakeCameraParams<T>(cur), cur_from_world);
}

/// A seed's posterior mean in the current image and how it moves there with mu.
template <typename T>
struct Projection {
  MaskOf<T> visible;  ///< In front of the camera and inside of the lens model's range.
  T x, y;             ///< [px]
  T dx, dy;           ///< Unit direction of the epipolar line, towards larger mu.
  T rate;             ///< Speed along it [px per unit of mu], >= 0.
  T foreshortening;   ///< q: the line is traversed as k / (1 - k q), see MuStep().
  T scale;            ///< Size of the patch in the current image over that in the reference image.
};

/// Projects the posterior mean mu of a seed with unit-free bearing (bx, by, 1) into the current
/// frame.
///
/// With f = (bx, by, 1) / |.| and d = R f, the point is P = d Z + t, or with ρ = 1/Z, up to scale,
/// P = d + t ρ; in both cases P = A + c B and dP/dc = B, for the coordinate c = c0 + mu (c1 - c0).
/// So d(x, y)/dmu = (B_xy - (x, y) B_z)(c1 - c0) / P_z, and the distortion's Jacobian and focal
/// lengths turn it to pixels. (docs/algorithm.md, "Projection")
template <typename Model, typename T, typename S>
LIVEMVS_HD inline Projection<T> ProjectSeed(const RelativeView<S>& view,
                                            DepthCoordinate coordinate,
                                            const Interval<T>& interval,
                                            T bx,
                                            T by,
                                            T mu) {
  const T inv_norm = T(1) / Sqrt(bx * bx + by * by + T(1));
  const T d0 = (view.r[0] * bx + view.r[1] * by + view.r[2]) * inv_norm;
  const T d1 = (view.r[3] * bx + view.r[4] * by + view.r[5]) * inv_norm;
  const T d2 = (view.r[6] * bx + view.r[7] * by + view.r[8]) * inv_norm;
  const T length = interval.c1 - interval.c0;
  const T c = interval.c0 + mu * length;
  const bool depth = coordinate == DepthCoordinate::kDepth;
  const T alpha = depth ? c : T(1);  // P = alpha d + beta t
  const T beta = depth ? T(1) : c;
  const T px = alpha * d0 + beta * view.t[0];
  const T py = alpha * d1 + beta * view.t[1];
  const T pz = alpha * d2 + beta * view.t[2];
  Projection<T> p;
  p.visible = (pz > T(1e-6) * alpha) & (c > T(0));
  const T inv_z = T(1) / Select(p.visible, pz, T(1));
  const T x = px * inv_z;
  const T y = py * inv_z;
  p.visible = p.visible & (x * x + y * y <= T(view.camera.r2_max));
  const T b0 = depth ? d0 : T(view.t[0]);
  const T b1 = depth ? d1 : T(view.t[1]);
  const T b2 = depth ? d2 : T(view.t[2]);
  const T gx = (b0 - x * b2) * length * inv_z;
  const T gy = (b1 - y * b2) * length * inv_z;
  const DistortedPoint<T> distorted = Model::Distort(view.camera.k, x, y);
  p.x = view.camera.fx * distorted.x + view.camera.cx;
  p.y = view.camera.fy * distorted.y + view.camera.cy;
  const T ux = view.camera.fx * (distorted.xx * gx + distorted.xy * gy);
  const T uy = view.camera.fy * (distorted.yx * gx + distorted.yy * gy);
  p.rate = Sqrt(ux * ux + uy * uy);
  const T inv_rate = Select(p.rate > T(0), T(1) / p.rate, T(0));
  p.dx = ux * inv_rate;
  p.dy = uy * inv_rate;
  p.foreshortening = length * b2 * inv_z;
  // Planar depths: alpha inv_norm in the reference, pz in the current camera.
  p.scale = view.focal_ratio * alpha * inv_norm * inv_z;
  return p;
}

/// The change of mu that moves the projection by `offset_px` along the line. Exact for a pinhole:
/// from (P0 + Δ B)_xy = X (P0 + Δ B)_z follows Δmu = k / (1 - k q), k = offset / rate. Not valid,
/// and negative in the denominator, beyond the vanishing point of the ray.
template <typename T>
LIVEMVS_HD inline T MuStep(const Projection<T>& p, T offset_px) {
  const T k = offset_px / p.rate;
  const T denominator = T(1) - k * p.foreshortening;
  return k / Select(denominator > T(1e-3), denominator, T(1e-3));
}

/// The inverse of MuStep: where along the line a change of mu leads [px].
template <typename T>
LIVEMVS_HD inline T OffsetOfMuStep(const Projection<T>& p, T mu_step) {
  const T denominator = T(1) + mu_step * p.foreshortening;
  return p.rate * mu_step / Select(denominator > T(1e-3), denominator, T(1e-3));
}

/// The samples i of the epipolar line, at (x, y) + i (dx, dy), that a search visits: whole numbers,
/// held as T. Empty: last < first.
template <typename T>
struct SearchRange {
  T first;
  T last;
};

/// Narrows [lo, hi], offsets along a line, to where origin + offset * direction is in [min, max];
/// empty, hi < lo, where that is nowhere.
template <typename T>
LIVEMVS_HD inline void ClipOffsets(T origin, T direction, T min, T max, T* lo, T* hi) {
  const T tiny = T(1e-6);
  const MaskOf<T> moves = (direction > tiny) | (direction < -tiny);
  const T divisor = Select(moves, direction, T(1));
  const T s0 = (min - origin) / divisor;
  const T s1 = (max - origin) / divisor;
  const T smaller = Select(s0 < s1, s0, s1);
  const T larger = Select(s0 < s1, s1, s0);
  const T at_rest = Select((origin >= min) & (origin <= max), *hi, *lo - T(1));
  *lo = Select(moves, Select(*lo > smaller, *lo, smaller), *lo);
  *hi = Select(moves, Select(*hi < larger, *hi, larger), at_rest);
  *hi = Select(max >= min, *hi, *lo - T(1));
}

/// The samples to visit for a window of `radius_px` round the projection, one more on each side so
/// that a maximum at its end can be told from a slope, clipped to the seed's interval (again with a
/// sample to spare) and to where the patch, reaching `margin_px` from its centre, lies in the
/// image.
template <typename T, typename S>
LIVEMVS_HD inline SearchRange<T> ClipSearch(
    const RelativeView<S>& view, const Projection<T>& p, T mu, T radius_px, T margin_px) {
  const T from_mu0 = OffsetOfMuStep(p, -mu) - T(1);
  const T to_mu1 = OffsetOfMuStep(p, T(1) - mu) + T(1);
  T lo = -radius_px - T(1);
  T hi = radius_px + T(1);
  lo = Select(lo > from_mu0, lo, from_mu0);
  hi = Select(hi < to_mu1, hi, to_mu1);
  ClipOffsets(p.x, p.dx, margin_px, T(view.width) - T(1) - margin_px, &lo, &hi);
  ClipOffsets(p.y, p.dy, margin_px, T(view.height) - T(1) - margin_px, &lo, &hi);
  const MaskOf<T> some = hi >= lo;
  return {Select(some, Ceil(lo), T(0)), Select(some, Floor(hi), T(-1))};
}

}  // namespace livemvs
