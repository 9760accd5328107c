#pragma once

#include <functional>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"

namespace livemvs::testing_support {

/// A slanted, textured plane before a camera, rendered point by point; the ground truth of tests.
/// In front of world z = 0, around (0, 0, 1): z = 1 + 0.3 x + 0.2 y.
struct PlaneScene {
  Camera camera{CameraModel::kPinhole, 200, 150, 190, 192, 98.5, 76.25, {}};
  double contrast = 45;     ///< Standard deviation of the texture [grey levels].
  double noise = 1;         ///< Standard deviation of the image noise [grey levels].
  double plain_left = -10;  ///< World x below which there is no texture, only noise.
  unsigned seed = 1;        ///< Of texture and noise.

  /// The frame seen from a pose.
  PosedFrame Render(const Rigid3d& cam_from_world, std::int64_t index) const;

  /// Frames from poses, numbered.
  std::vector<PosedFrame> Render(const std::vector<Rigid3d>& cam_from_world) const;

  /// Signed distance of a world point from the plane, along z. [scene]
  static double HeightAbove(const Eigen::Vector3d& p) {
    return p.z() - (1 + 0.3 * p.x() + 0.2 * p.y());
  }
};

/// A hand that moves sideways, `step` per frame, looking ahead, with a little rotation.
std::vector<Rigid3d> SidewaysPath(int frames, double step = 0.012);

/// Small pool, no time limits: what the tests of the whole algorithm start from. Everything that
/// they rely on is set here, so that they do not depend on the defaults.
Options TestOptions();

}  // namespace livemvs::testing_support
