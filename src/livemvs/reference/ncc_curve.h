#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/pose.h"

namespace livemvs::reference {

/// A calibrated picture. The pixels are not owned.
struct PosedView {
  ImageView<std::uint8_t> image;
  Projector projector;
  Rigid3d cam_from_world;
};

/// An optic ray, and the patch W around its pixel.
struct RayPatch {
  Eigen::Vector3d origin;     ///< Camera centre in the world [scene].
  Eigen::Vector3d direction;  ///< Unit, in the world.
  std::vector<double> patch;  ///< 5x5 grey levels, row-major.

  /// The point x(Z) on the ray.
  Eigen::Vector3d At(double depth) const { return origin + depth * direction; }

  /// Standard deviation of the patch's grey levels.
  double Contrast() const;
};

/// The ray of the pixel (x, y) of a view, whose patch must lie inside of the picture.
/// @throws std::invalid_argument where it does not, or where no ray of the lens model goes there.
RayPatch MakeRayPatch(const PosedView& reference, int x, int y);

/// A local maximum of the NCC along a ray: one measurement x_n of [VH11] Sec. 3.
struct NccMaximum {
  double depth;         ///< Distance along the ray [scene]: vertex of a parabola.
  double score;         ///< NCC at the vertex.
  double depth_per_px;  ///< Depth that one pixel of the neighbour is worth here: tau at 1 px.
};

/// NCC over depth, [VH11] Fig. 2a. The columns `depths` and `scores` are of equal length.
struct NccCurve {
  std::vector<double> depths;      ///< [scene], ascending.
  std::vector<double> scores;      ///< NCC in [-1, 1].
  std::vector<NccMaximum> maxima;  ///< All local maxima, by depth.
};

/// Compares the ray's patch with a neighbour's patches of the same shape (unwarped, as published)
/// at the projections of x(Z), z_min <= Z <= z_max. Samples are at most `max_step_px` apart in the
/// neighbour's image; where the ray's point is out of its view there are none. A maximum lies
/// between two lower samples, so never at an end of what is seen; maxima are refined by a parabola
/// through three samples. A patch without contrast has no curve.
NccCurve TraceNcc(const RayPatch& ray,
                  const PosedView& neighbour,
                  double z_min,
                  double z_max,
                  double max_step_px = 0.5);

}  // namespace livemvs::reference
