#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// A camera to draw with, and what it looks at.
struct RenderView {
  Camera camera;
  Rigid3d cam_from_world;
  Eigen::Vector3d up = {0, 0, 1};  ///< Unit, in the world.
  double focus_depth = 1;          ///< Distance to the middle of what is shown. [scene]
};

/// Which side to look from.
struct ViewOptions {
  int width = 1280;                          ///< [px]
  int height = 960;                          ///< [px]
  double field_of_view_deg = 35;             ///< Vertical.
  std::optional<Eigen::Vector3d> direction;  ///< From the scene to the viewer; default: guessed.
  std::optional<Eigen::Vector3d> up;         ///< Default: guessed.
  double margin = 0.06;                      ///< Left free at each edge, as a share of the picture.
  double turn_deg = 0;      ///< Turns the viewer about `up`, from above to the left.
  bool from_above = false;  ///< Looks down `up`.
  bool level = false;       ///< Looks horizontally.

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// Where most of the cameras were: the mean of the directions in which the points were seen. Zero
/// where they cancel or are unknown.
Eigen::Vector3d MeanViewingDirection(const PointCloud& cloud);

/// Guesses which way is up from the viewing direction and the planes in the cloud: people film
/// slightly from above, and tables, floors and the like are level. One of the axes' directions.
/// @param towards_cameras  MeanViewingDirection().
Eigen::Vector3d GuessUp(const PointCloud& cloud, const Eigen::Vector3d& towards_cameras);

/// Which way is up for the cameras that filmed a scene: the direction level to all their rows,
/// since people hold a camera level; where all look the same way, that of their columns counts.
/// Unit; zero without cameras.
Eigen::Vector3d UpOfCameras(const std::vector<Rigid3d>& cams_from_world);

/// A view from `options` that shows all but the outermost percent of the finite points. Without
/// points it looks at the origin.
/// @param towards_cameras  MeanViewingDirection(), used where no direction is given.
RenderView FitView(const PointCloud& cloud,
                   const Eigen::Vector3d& towards_cameras,
                   const ViewOptions& options);

}  // namespace livemvs
