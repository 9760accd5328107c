#pragma once

#include <cstdint>
#include <string>

#include "frame_input.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/error.h"
#include "livemvs/tracking/board_tracker.h"

namespace livemvs::app {

/// A recording of a board, and which of its frames to look at.
struct SelfCameraInput {
  FrameInput input;
  Board board;
  std::string board_name;  ///< For messages.
  std::int64_t first_frame = 0;
  std::int64_t last_frame = -1;  ///< -1: all.
};

/// What to throw where none of the frames shows the board.
Error BoardNotSeen(const std::string& source, std::int64_t frames, const std::string& board);

/// Goes through a recording only to find the camera's focal length, k1 and k2 from the board, and
/// says what it found: a recording can be read twice, so that its first frames have poses, too.
/// @throws Error (kBadInput) where the board is not seen, (kFailed) where its views do not tell
/// the camera; CLI::RuntimeError where interrupted.
Camera FindCameraInRecording(const SelfCameraInput& recording,
                             const TrackerOptions& options,
                             const std::string& progress_mode);

}  // namespace livemvs::app
