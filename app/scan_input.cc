#include "scan_input.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "frame_input.h"
#include "interrupt.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/pipe_source.h"
#include "livemvs/pipeline/search_mode.h"
#include "livemvs/tracking/board_tracker.h"
#include "self_camera.h"

namespace livemvs::app {
namespace {

/// Frames that are fed again when a recording is resumed, so that the seeds that were alive grow
/// again: twice as many as a seed may meet, because it does not meet each.
std::int64_t WarmUpFrames(const ScanArguments& args) {
  return std::int64_t{2} * DefaultOptions().max_age * args.step;
}

std::int64_t LastIndex(const Replay& before) {
  std::int64_t last = -1;
  for (const FrameMessage& frame : before.frames()) last = std::max(last, frame.index);
  return last;
}

double LastTime(const Replay& before) {
  double last = 0;
  for (const FrameMessage& frame : before.frames()) last = std::max(last, frame.timestamp);
  return last;
}

// Where a recording is taken up.
std::int64_t FirstFrame(const ScanArguments& args, const Replay* before) {
  if (before == nullptr) return args.first_frame;
  const std::int64_t back = std::max<std::int64_t>(0, LastIndex(*before) + 1 - WarmUpFrames(args));
  // Every step-th frame, counted from the first.
  const std::int64_t steps = (std::max(back, args.first_frame) - args.first_frame) / args.step;
  return args.first_frame + steps * args.step;
}

// Intrinsics as given, else as found beside the recording, else none: the tracker finds them.
std::optional<Camera> CalibrationOf(const ScanArguments& args,
                                    const ScanInput& input,
                                    const Replay* before) {
  const FrameSource::Info info = input.source->info();
  std::optional<Camera> camera;
  if (before != nullptr && before->camera()) {
    camera = before->camera();
  } else if (!input.live) {
    camera = CameraFor(args.calibration, FindFrames(args.data));
  } else if (!args.calibration.empty()) {
    camera = CameraFor(args.calibration, {});
  }
  if (!camera) return camera;
  if (camera->width == 0) {
    camera->width = info.width;
    camera->height = info.height;
  }
  if (camera->width != info.width || camera->height != info.height) {
    throw BadInput("the calibration is for " + std::to_string(camera->width) + " x " +
                   std::to_string(camera->height) + " pictures, but " + info.description + " are " +
                   std::to_string(info.width) + " x " + std::to_string(info.height) +
                   "; calibrate at this size or film at that one");
  }
  return camera;
}

SceneRange RangeAbove(const ScanArguments& args, const Board& board) {
  SceneRange range;
  const std::optional<Box> given = BoxOf(args.method);
  range.box = given ? *given : BoxAbove(board, args.height);
  range.origin = given ? "--box" : "the room above the board";
  // The box alone counts; these only keep the camera itself out.
  const double diagonal = (range.box->max - range.box->min).norm();
  range.margin = MakeOptions(args.method).box_margin * diagonal;
  range.near = args.method.near > 0 ? args.method.near : 0.02 * diagonal;
  range.far = args.method.far > 0 ? args.method.far : 100 * diagonal;
  try {
    range.Check();
  } catch (const std::invalid_argument& e) {
    throw BadInput(e.what());
  }
  return range;
}

void OpenPosed(const ScanArguments& args, const Replay* before, ScanInput* input) {
  DatasetOptions options;
  options.data = args.data;
  options.poses = args.poses;
  options.images = args.images;
  options.camera = args.calibration;
  options.pose_convention = args.convention;
  options.first_frame = args.first_frame;
  options.last_frame = args.last_frame;
  options.step = args.step;
  options.cancelled = Interrupted;
  // Range and search are those of the whole, wherever it is taken up.
  std::unique_ptr<Dataset> dataset = OpenDataset(options);
  input->settings.range = RangeOf(args.method, *dataset);
  input->settings.method = FitToData(MakeOptions(args.method), *dataset, input->settings.range);
  if (before != nullptr) {
    options.first_frame = FirstFrame(args, before);
    dataset = OpenDataset(options);
  }
  input->expected = static_cast<std::int64_t>(dataset->views().size());
  input->player = std::make_unique<DatasetPlayer>(std::move(dataset), args.realtime);
  input->source = input->player->source();
  input->poses = input->player->poses();
}

std::unique_ptr<LiveSource> OpenPictures(const ScanArguments& args,
                                         const Replay* before,
                                         ScanInput* input) {
  if (IsLive(args)) {
    input->live = true;
    return OpenLive(args);
  }
  std::unique_ptr<FrameSource> recording = FindFrames(args.data).Open();
  PlaybackOptions options;
  options.realtime = args.realtime;
  options.first_frame = FirstFrame(args, before);
  options.last_frame = args.last_frame;
  options.step = args.step;
  input->expected = (recording->info().frame_count - options.first_frame) / args.step;
  return PlayBack(std::move(recording), options);
}

void OpenWithBoard(const ScanArguments& args, const Replay* before, ScanInput* input) {
  input->board = ReadBoard(args.board);
  input->owned_source = OpenPictures(args, before, input);
  input->source = input->owned_source.get();
  LogInfo(input->source->info().description);
  std::optional<Camera> camera = CalibrationOf(args, *input, before);
  // A recording can be read twice; what is live calibrates while it is filmed.
  if (!camera && !input->live && !args.realtime) {
    camera = FindCameraInRecording({.input = FindFrames(args.data),
                                    .board = *input->board,
                                    .board_name = args.board.string(),
                                    .first_frame = args.first_frame,
                                    .last_frame = args.last_frame},
                                   {},
                                   args.progress);
  }
  input->owned_poses = MakeBoardTracker(*input->board, camera);
  input->poses = input->owned_poses.get();
  input->settings.range = RangeAbove(args, *input->board);
  input->settings.method = ResolveSearch({}, input->settings.range, MakeOptions(args.method));
  LogInfo("looking for surfaces at " + Describe(input->settings.range));
}

}  // namespace

ScanInput OpenScanInput(const ScanArguments& args, const Replay* before) {
  ScanInput input;
  if (args.board.empty()) {
    if (IsPipe(args.data)) {
      throw BadInput(args.data.string() +
                     ": pictures from a pipe have no poses; give --board for the sheet in them");
    }
    OpenPosed(args, before, &input);
  } else {
    OpenWithBoard(args, before, &input);
  }
  TrackingStageOptions& stages = input.settings.stages;
  stages.capture.drop_oldest = input.live || args.realtime;
  stages.patience = args.patience;
  // A recording that takes long over a frame is not lost.
  if (!input.live) stages.capture.lost_after = 1e9;
  if (before != nullptr && input.live) {
    stages.index_offset = LastIndex(*before) + 1;
    const double now =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    stages.time_offset =
        std::max(LastTime(*before) + 1, now - before->sessions().front().unix_time);
  }
  return input;
}

}  // namespace livemvs::app
