#pragma once

#include <memory>
#include <optional>

#include "livemvs/tracking/board.h"
#include "livemvs/tracking/pose_source.h"

namespace livemvs {

struct TrackerOptions {
  int min_corners = 8;            ///< A pose rests on at least so many corners.
  double max_rms_px = 0.8;        ///< Of their reprojection [px]; more of it is no pose.
  double max_sigma_px = 1.0;      ///< Largest expected error in the room above the sheet [px].
  double max_motion_px = 60;      ///< How far from its prediction the board is looked for [px].
  double max_gap_seconds = 0.25;  ///< After a longer one nothing is predicted.
  int detect_width = 800;         ///< Pictures twice as wide are searched at half their size [px].

  void Check() const;  ///< @throws std::invalid_argument
};

/// Finds the pose of the camera from a printed board in its picture. Once the board was found by
/// its markers, its corners are looked for where the motion so far predicts them; where that fails
/// the markers are looked for again, in the same picture. A pose is given only where the corners
/// agree on it and the markers read so as they are printed.
///
/// The world is the board's (see Board). Poses do not depend on earlier frames other than through
/// the places where corners are looked for.
/// @param camera   Its intrinsics; width and height 0 stand for those of the first picture. Without
///                 it the first seconds serve to find them (focal length, k1, k2; principal point
///                 in the middle); until then there are no poses.
/// @throws std::invalid_argument for a board, camera or options that make no sense.
std::unique_ptr<PoseSource> MakeBoardTracker(const Board& board,
                                             const std::optional<Camera>& camera,
                                             const TrackerOptions& options = {});

}  // namespace livemvs
