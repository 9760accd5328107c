#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/bundle.h"

namespace livemvs {

struct CalibratorOptions {
  CameraModel model = CameraModel::kBrownConrady;  ///< Or kKannalaBrandt (fisheye).
  int distortion_terms = 5;      ///< Brown-Conrady: 0, 2 (k1 k2), 4 (and p1 p2) or 5 (and k3).
  bool principal_point = true;   ///< Estimate it; else it is the middle of the picture.
  int min_views = 8;             ///< Fewer different views are refused.
  int max_views = 40;            ///< Of more, the most different ones are kept.
  double min_difference = 0.04;  ///< Between two views: mean shift of the sheet's corners [widths].
  int min_corners = 12;          ///< Of a view.
  double max_blur_px = 4;        ///< Blurred views are not used [px of motion].
  double max_rms_px = 0.6;       ///< A worse fit is refused [px].
  double max_focal_sigma = 0.003;  ///< So is a less certain focal length [relative].
  double min_coverage = 0.3;       ///< So are views that leave more of the picture empty [part].

  void Check() const;  ///< @throws std::invalid_argument
};

/// Corners of the board in one picture.
struct CalibrationView {
  std::vector<PointObservation> observations;
  double blur_px = 0;
};

struct Calibration {
  Camera camera;
  double rms_px = 0;
  std::array<double, kIntrinsics> sigma{};  ///< Standard deviations, as in BundleResult.
  int views = 0;
  int corners = 0;  ///< In all views.
  std::vector<double> view_rms_px;
  double coverage = 0;              ///< Part of the picture where corners were seen.
  double tilt_deg = 0;              ///< Of the view that is tilted most against the sheet.
  std::vector<int> coverage_cells;  ///< Corners in each cell of a grid of 12 x 9, by rows.
  /// Why it should not be used, for people; empty: it is good.
  std::string problem;
};

/// Collects views of a board that differ, and finds the camera's intrinsics from them.
class Calibrator {
 public:
  static constexpr int kCellColumns = 12, kCellRows = 9;

  /// @param width, height  Of the pictures [px].
  Calibrator(int width, int height, const CalibratorOptions& options = {});

  /// Keeps a view if it is sharp, shows enough and differs from those that are kept.
  /// @return Whether it was kept.
  bool Add(const CalibrationView& view);

  int views() const { return static_cast<int>(kept_.size()); }

  /// Calibrates from the views so far. May be called again after more views.
  /// @param start  Where to start from; nothing: found from the views.
  Calibration Solve(const std::optional<Camera>& start = std::nullopt) const;

 private:
  using Outline = std::array<Eigen::Vector2d, 4>;
  struct Kept {
    CalibrationView view;
    Outline outline;  // of the seen part of the sheet, in picture widths
    Eigen::Matrix3d homography;
  };
  double Difference(const Outline& a, const Outline& b) const;
  double NearestDifference(const Outline& outline, std::size_t except) const;
  std::vector<double> FocalGuesses() const;
  std::vector<BundleView> PosedViews(const Camera& camera) const;
  BundleOptions Freedom(int level) const;
  Camera StartCamera(double focal) const;
  void Cover(Calibration* calibration) const;
  std::string Judge(const Calibration& calibration) const;

  int width_ = 0, height_ = 0;
  CalibratorOptions options_;
  std::vector<Kept> kept_;
};

}  // namespace livemvs
