// livemvs track: from a recording of a board to the poses of its frames.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.h"
#include "frame_input.h"
#include "interrupt.h"
#include "livemvs/core/error.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/pose_writer.h"
#include "livemvs/io/tum.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/board_tracker.h"
#include "output_check.h"
#include "progress.h"
#include "self_camera.h"
#include "track_report.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

struct TrackArguments {
  fs::path data, board, output, camera_output, report;
  std::string camera, format = "auto", progress = "auto";
  TrackerOptions options;
};

std::string FormatOf(const TrackArguments& a) {
  if (a.format != "auto") return a.format;
  if (a.output.extension() == ".json") return "transforms";
  return a.output.extension().empty() ? "colmap" : "tum";
}

// As another program finds the picture: an image by its path from the folder of the poses, a frame
// of a video by the name that extracting gives it.
std::string ImageName(const FrameInput& input, const SourceFrame& frame) {
  if (!input.video) return (input.path.filename() / frame.name).generic_string();
  char name[40];
  std::snprintf(name, sizeof name, "images/%06lld.png", static_cast<long long>(frame.index));
  return name;
}

std::vector<TrackedPose> TrackAll(const TrackArguments& a,
                                  const FrameInput& input,
                                  PoseSource* tracker,
                                  TrackReport* report) {
  const auto frames = input.Open();
  std::vector<TrackedPose> poses;
  Progress progress(ParseProgressMode(a.progress));
  while (const auto frame = Interrupted() ? std::nullopt : frames->Next()) {
    const auto start = std::chrono::steady_clock::now();
    const PoseEstimate e = tracker->Estimate(*frame->picture, frame->timestamp);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    report->Add(frame->index, frame->timestamp, e, took.count());
    if (e.cam_from_world) {
      poses.push_back(
          {frame->index, frame->timestamp, ImageName(input, *frame), *e.cam_from_world});
    }
    progress.Show({"track", report->frames(), frames->info().frame_count});
  }
  progress.Finish();
  return poses;
}

void Write(const TrackArguments& a, const Camera& camera, const std::vector<TrackedPose>& poses) {
  const std::string format = FormatOf(a);
  if (format == "tum") {
    std::vector<StampedPose> stamped;
    stamped.reserve(poses.size());
    for (const TrackedPose& pose : poses) stamped.push_back({pose.timestamp, pose.cam_from_world});
    WriteTumTrajectory(a.output, stamped, "livemvs track; the world is the board's, metres");
  } else if (format == "rows") {
    WritePoseRows(a.output, poses);
  } else if (format == "transforms") {
    WriteTransforms(a.output, camera, poses);
  } else {
    WriteColmapText(a.output, camera, poses);
  }
  if (!a.camera_output.empty()) WriteOpenCvYaml(a.camera_output, camera, {"livemvs track"});
}

void RunTrack(const TrackArguments& a) {
  if (FormatOf(a) != "colmap") CheckOutputs({{a.output, "the poses", "", ""}}, {a.data, a.board});
  CheckOutputs({{a.camera_output, "the camera", "an OpenCV YAML file", "%YAML"},
                {a.report, "the report", "a table", "frame,"}},
               {a.data, a.board});
  const Board board = ReadBoard(a.board);
  const FrameInput input = FindFrames(a.data);
  std::optional<Camera> camera = CameraFor(a.camera, input);
  CatchInterrupts();
  if (!camera) {
    camera = FindCameraInRecording({input, board, a.board.string()}, a.options, a.progress);
  }
  const auto tracker = MakeBoardTracker(board, camera, a.options);
  TrackReport report;
  const std::vector<TrackedPose> poses = TrackAll(a, input, tracker.get(), &report);
  report.Print();
  if (!a.report.empty()) report.WriteTable(a.report);
  if (poses.empty()) {
    throw BadInput(a.data.string() + ": no pose in any of " + std::to_string(report.frames()) +
                   " frames: " + report.commonest_problem());
  }
  Write(a, tracker->camera(), poses);
  std::printf("%s\n", a.output.c_str());
  if (Interrupted()) throw CLI::RuntimeError(kExitInterrupted);
}

}  // namespace

void AddTrackCommand(CLI::App& app) {
  auto a = std::make_shared<TrackArguments>();
  CLI::App* command = app.add_subcommand(
      "track",
      "Find the poses of a camera from a recording of a board, for this or other programs");
  command->add_option("--data", a->data, "Video, or folder of images")->required();
  command->add_option("--board", a->board, "Description of the board, from 'livemvs board'")
      ->required();
  command->add_option("-o,--output", a->output, "Poses to write: a file, or a folder for COLMAP")
      ->required();
  command
      ->add_option("--format",
                   a->format,
                   "tum, rows (frame and 3x4 cam_from_world), transforms or colmap; auto: by the "
                   "output's name (.json: transforms; a folder: colmap; else tum)")
      ->check(CLI::IsMember({"auto", "tum", "rows", "transforms", "colmap"}))
      ->capture_default_str();
  command->add_option(
      "--camera",
      a->camera,
      "OpenCV YAML file, fx,fy,cx,cy[,k1,k2,p1,p2[,k3...]], or 'self'; default: the "
      "calibration beside the data, else 'self'");
  command->add_option("--camera-output", a->camera_output, "Also write the camera (.yaml)");
  command->add_option("--report", a->report, "Also write a table of all frames (.csv)");
  command->add_option("--min-corners", a->options.min_corners, "A pose rests on at least so many")
      ->capture_default_str();
  command->add_option("--max-rms", a->options.max_rms_px, "A pose that fits worse is none [px]")
      ->capture_default_str();
  command->add_option("--progress", a->progress, "auto, line, json or none")->capture_default_str();
  command->footer(
      "The world is the board's: origin in its middle, x right and y up on the sheet, z towards "
      "the "
      "objects, metres.\n\n"
      "Examples:\n"
      "  livemvs track --data video.mp4 --board board.json -o poses.txt\n"
      "  livemvs track --data video.mp4 --board board.json --camera camera.yaml -o sparse\n"
      "  livemvs run --data video.mp4 --poses poses.txt --camera camera.yaml -o cloud.ply");
  command->callback([a] { RunTrack(*a); });
}

}  // namespace livemvs::app
