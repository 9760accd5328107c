#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "livemvs/core/image.h"

namespace livemvs {

/// Where four squares are expected to meet, and how the sheet is seen there.
struct CornerView {
  /// Homography from the sheet around the corner, (dx, dy, 1) [m], to homogeneous pixels.
  Eigen::Matrix3d pixel_from_sheet;
  bool black_up_right = false;  ///< As in BoardCorner.

  Eigen::Vector2d Pixel(double dx, double dy) const {
    const Eigen::Vector3d p = pixel_from_sheet * Eigen::Vector3d(dx, dy, 1);
    return p.head<2>() / p.z();
  }
};

struct CornerFitOptions {
  int scale = 1;                ///< The picture is looked at with its pixels averaged by scale².
  double radius_px = 6;         ///< Of what is compared [averaged pixels], where the sheet allows.
  double max_shift_px = 2.5;    ///< A corner further from its expected place is none [likewise].
  double min_contrast = 10;     ///< Between black and white squares [grey levels].
  double max_asymmetry = 0.16;  ///< Largest rms difference of opposite points, of the contrast.
};

struct CornerFit {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 0;  ///< Standard deviation of each coordinate, from what does not fit.
  double contrast = 0;  ///< [grey levels]
  double blur_px = 0;   ///< Standard deviation of the wider edge's blur.
};

/// Sizes of the pattern around a corner. [m]
struct CornerGeometry {
  double margin = 0;  ///< White between a square's side and its marker.
  double radius = 0;  ///< The pattern is its own image under a half turn up to here.
};

/// Finds the corner as the centre of symmetry of the pattern: the point about which the picture, in
/// coordinates of the sheet, equals itself turned by half. Neither the light, nor blur of lens or
/// motion, nor perspective moves that point; the edge of something in front of the sheet breaks the
/// symmetry and is noticed. Gauss-Newton on the shift of the sheet's grid, min Σ w (I(p(s) + t) -
/// I(p(-s) + t))², samples a pixel apart.
/// @return Nothing where the corner is hidden, blurred beyond recognition, too small or outside.
std::optional<CornerFit> FitCorner(ImageView<std::uint8_t> image,
                                   const CornerView& view,
                                   const CornerGeometry& geometry,
                                   const CornerFitOptions& options);

}  // namespace livemvs
