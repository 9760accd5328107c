#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"
#include "livemvs/tracking/pose_fit.h"
#include "livemvs/tracking/projection.h"

namespace livemvs {

/// One picture of the board, as the bundle adjustment takes it.
struct BundleView {
  Rigid3d cam_from_world;
  std::vector<PointObservation> observations;
};

struct BundleOptions {
  /// Which intrinsics may change: fx fy cx cy and the distortion in Camera's order.
  std::array<bool, kIntrinsics> free{};
  bool equal_focal = true;  ///< fx and fy change together (square pixels).
  /// The sheet may be bent: z = a x² + b x y + c y² over its plane.
  bool bend = false;
  double floor_px = 0.05;     ///< As in PoseFitOptions.
  double outlier_sigmas = 4;  ///< Likewise.
  int max_steps = 30;
};

struct BundleResult {
  bool converged = false;  ///< False: no solution, and the rest is as it was at the start.
  Camera camera;
  std::vector<Rigid3d> cam_from_world;  ///< One per view.
  std::vector<double> view_rms_px;      ///< Likewise, of the inliers; 0 where there are none.
  double rms_px = 0;                    ///< Of all inliers.
  int inliers = 0;
  /// Standard deviations of the intrinsics, 0 where they were not free; scaled by what fits worse
  /// than it should.
  std::array<double, kIntrinsics> sigma{};
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();  ///< a b c [1/m]
};

/// Bundle adjustment over the poses of all views, the camera's intrinsics and the sheet's bend:
/// min Σ ρ(‖pixel - π(K, T_v X)‖² / σ²), Cauchy's ρ first, then squares of the inliers. The board's
/// own coordinates fix the gauge. Levenberg-Marquardt; the poses are eliminated one by one (Schur
/// complement), what is common to all views is solved for, so that a step costs O(observations).
BundleResult AdjustBundle(const Camera& camera,
                          const std::vector<BundleView>& views,
                          const BundleOptions& options);

}  // namespace livemvs
