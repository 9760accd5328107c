#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "livemvs/core/pose.h"

namespace livemvs {

/// How a synthetic camera moves.
enum class PathKind {
  kOrbit,       ///< Hand-held, around the target, looking at it.
  kHemisphere,  ///< Views spread evenly over a hemisphere around the target, as of a gantry.
  kWalk,        ///< Hand-held walk around a room (the scene "room"), looking at the other side.
};

/// @throws std::invalid_argument for a name that is none of orbit, hemisphere, walk.
PathKind PathKindFromName(const std::string& name);

struct PathOptions {
  PathKind kind = PathKind::kOrbit;
  int frames = 120;
  double frames_per_second = 30;
  Eigen::Vector3d target = {0, 0, 0.04};  ///< What the camera looks at [m].
  double radius = 0.55;                   ///< Horizontal (hemisphere: true) distance to it [m].
  double height = 0.38;                   ///< Of the orbit above the target [m].
  double arc_deg = 100;                   ///< Of the orbit about the vertical.
  double start_deg = -140;                ///< Azimuth of the orbit's first camera, from +x.
  double wobble = 1;                      ///< Strength of the hand's unrest; 0: none.
  std::uint64_t seed = 1;                 ///< Of the unrest.

  void Check() const;  ///< @throws std::invalid_argument
};

/// A path that suits a scene by that name (see SceneOptions).
PathOptions DefaultPath(const std::string& scene);

/// The pose (cam_from_world) at a time in frames, which need not be whole: blur needs times
/// between.
Rigid3d PoseAt(const PathOptions& options, double frame);

/// Poses of all frames.
std::vector<Rigid3d> MakePath(const PathOptions& options);

/// cam_from_world of a camera at `eye` that looks at `target`, the image's up towards world z.
Rigid3d LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

}  // namespace livemvs
