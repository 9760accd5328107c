#include "self_camera.h"

#include <cstdio>
#include <memory>
#include <optional>

#include "commands.h"
#include "interrupt.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "progress.h"

namespace livemvs::app {
namespace {

struct Seen {
  std::int64_t frames = 0, with_board = 0;
  std::string problem;  // of the last frame without a pose
};

Seen Watch(const SelfCameraInput& in, const std::string& progress_mode, PoseSource* tracker) {
  const auto frames = in.input.Open();
  Progress progress(ParseProgressMode(progress_mode));
  Seen seen;
  while (const auto frame = Interrupted() ? std::nullopt : frames->Next()) {
    if (frame->index < in.first_frame) continue;
    if (in.last_frame >= 0 && frame->index > in.last_frame) break;
    const PoseEstimate e = tracker->Estimate(*frame->picture, frame->timestamp);
    seen.with_board += e.observations > 0 ? 1 : 0;
    if (!e.cam_from_world) seen.problem = e.problem;
    progress.Show({"calibrate", ++seen.frames, frames->info().frame_count});
  }
  progress.Finish();
  if (Interrupted()) throw CLI::RuntimeError(kExitInterrupted);
  return seen;
}

}  // namespace

Error BoardNotSeen(const std::string& source, std::int64_t frames, const std::string& board) {
  return BadInput(source + ": board not seen in any of " + std::to_string(frames) +
                  " frames; is it the one that " + board + " describes?");
}

Camera FindCameraInRecording(const SelfCameraInput& recording,
                             const TrackerOptions& options,
                             const std::string& progress_mode) {
  const auto tracker = MakeBoardTracker(recording.board, std::nullopt, options);
  const Seen seen = Watch(recording, progress_mode, tracker.get());
  if (seen.with_board == 0) {
    throw BoardNotSeen(recording.input.path.string(), seen.frames, recording.board_name);
  }
  const Camera camera = tracker->camera();
  if (camera.fx <= 0) {
    throw Error(ErrorKind::kFailed,
                recording.input.path.string() +
                    ": the camera could not be calibrated from this recording (" + seen.problem +
                    "); film further around the board, or give a calibration, from 'livemvs "
                    "calibrate'");
  }
  char text[160];
  std::snprintf(text,
                sizeof text,
                "no calibration given: found focal length %.2f px, k1 %.4f, k2 %.4f from the board",
                camera.fx,
                camera.distortion[0],
                camera.distortion[1]);
  LogInfo(text);
  return camera;
}

}  // namespace livemvs::app
