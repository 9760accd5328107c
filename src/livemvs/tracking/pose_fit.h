#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// A point of the world and where a picture shows it.
struct PointObservation {
  Eigen::Vector3d point;  ///< In the world [m].
  Eigen::Vector2d pixel;  ///< [px]
  double sigma_px = 0.1;  ///< Expected error of each coordinate of the pixel.
};

struct PoseFitOptions {
  double floor_px = 0.05;     ///< No observation is trusted more than to this [px].
  double outlier_sigmas = 4;  ///< Observations that lie further off are left out in the end.
  int min_inliers = 4;
};

struct PoseFit {
  Rigid3d cam_from_world;
  double rms_px = 0;         ///< Of the inliers' distances.
  std::vector<bool> inlier;  ///< One per observation.
  int inliers = 0;
  /// Of (rotation vector [rad], translation [m]) in camera axes, scaled by what fits worse than it
  /// should.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// The bundle adjustment over one pose: min Σ ρ(‖pixel - π(T X)‖² / σ²), Cauchy's ρ first, then
/// squares of the inliers alone.
/// @return Nothing where too few observations agree, or the solution is degenerate or not finite.
std::optional<PoseFit> FitPose(const Camera& camera,
                               const std::vector<PointObservation>& observations,
                               const Rigid3d& initial,
                               const PoseFitOptions& options = {});

/// The poses from which a plane's points (z = 0) would look so: one or two, the better first, not
/// refined. Needs four or more.
std::vector<Rigid3d> PlanarPoses(const Camera& camera,
                                 const std::vector<PointObservation>& observations);

}  // namespace livemvs
