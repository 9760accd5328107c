// livemvs calibrate: from a recording of a board, or a camera before it, to its intrinsics.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.h"
#include "frame_input.h"
#include "interrupt.h"
#include "live_calibrate.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/calibration.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/calibrator.h"
#include "livemvs/tracking/corner_source.h"
#include "output_check.h"
#include "progress.h"
#include "self_camera.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments {
  LiveArguments input;
  fs::path board, output;
  bool fisheye = false, force = false;
  CalibratorOptions options;
  std::string progress = "auto";
};

// The corners of all frames of a recording, and what they tell.
LiveCalibrationResult CalibrateFromRecording(const CalibrateArguments& a) {
  const auto frames = FindFrames(a.input.data).Open();
  CornerSource corners(ReadBoard(a.board));
  std::optional<Calibrator> calibrator;  // made for the first frame's size
  LiveCalibrationResult result;
  Progress progress(ParseProgressMode(a.progress));
  while (const auto frame = Interrupted() ? std::nullopt : frames->Next()) {
    if (!calibrator) {
      calibrator.emplace(frame->picture->width(), frame->picture->height(), a.options);
    }
    ++result.frames;
    const CalibrationView view = corners.Find(*frame->picture);
    if (!view.observations.empty()) ++result.with_board;
    calibrator->Add(view);
    progress.Show({"look for the board", result.frames, frames->info().frame_count});
  }
  progress.Finish();
  if (calibrator) result.calibration = calibrator->Solve();
  return result;
}

// How many corners each part of the picture saw, as a map of characters.
void ShowCoverage(const Calibration& c) {
  if (c.coverage_cells.empty()) return;
  std::printf("seen in %.0f %% of the picture (. none, + up to 9, # more corners):\n",
              100 * c.coverage);
  for (int y = 0; y < Calibrator::kCellRows; ++y) {
    std::string row = "  ";
    for (int x = 0; x < Calibrator::kCellColumns; ++x) {
      const int n = c.coverage_cells[y * Calibrator::kCellColumns + x];
      row += n == 0 ? '.' : n < 10 ? '+' : '#';
    }
    std::printf("%s\n", row.c_str());
  }
}

void ShowNumbers(const Calibration& c, bool fisheye) {
  const Camera& k = c.camera;
  std::printf("%d views, %d corners, %.3f px rms, the most tilted view by %.0f degrees\n",
              c.views,
              c.corners,
              c.rms_px,
              c.tilt_deg);
  std::printf("fx %.3f +- %.3f  fy %.3f +- %.3f\n", k.fx, c.sigma[0], k.fy, c.sigma[1]);
  std::printf("cx %.3f +- %.3f  cy %.3f +- %.3f\n", k.cx, c.sigma[2], k.cy, c.sigma[3]);
  const char* const brown[5] = {"k1", "k2", "p1", "p2", "k3"};
  const char* const fish[4] = {"k1", "k2", "k3", "k4"};
  for (int i = 0; i < (fisheye ? 4 : 5); ++i) {
    std::printf("%s %.6f +- %.6f\n", fisheye ? fish[i] : brown[i], k.distortion[i], c.sigma[4 + i]);
  }
}

std::vector<std::string> Notes(const Calibration& c) {
  char text[200];
  std::snprintf(text,
                sizeof text,
                "livemvs calibrate: %d views, %d corners, %.4f px rms",
                c.views,
                c.corners,
                c.rms_px);
  std::vector<std::string> notes{text};
  std::snprintf(text,
                sizeof text,
                "standard deviations: fx %.4g fy %.4g cx %.4g cy %.4g",
                c.sigma[0],
                c.sigma[1],
                c.sigma[2],
                c.sigma[3]);
  notes.emplace_back(text);
  return notes;
}

void RunCalibrate(CalibrateArguments a) {
  if (a.input.data.empty() == a.input.device.empty()) {
    throw std::invalid_argument("give either --camera NUMBER or --data VIDEO");
  }
  CheckOutputs({{a.output, "the calibration", "an OpenCV YAML file", "%YAML"}},
               {a.input.data, a.board});
  if (a.fisheye) a.options.model = CameraModel::kKannalaBrandt;
  a.options.Check();
  CatchInterrupts();
  const bool live = IsLive(a.input);
  const LiveCalibrationResult result =
      live ? CalibrateFromLive(a.input, ReadBoard(a.board), a.options, a.progress)
           : CalibrateFromRecording(a);
  if (result.with_board == 0) {
    const std::string source =
        a.input.device.empty() ? a.input.data.string() : "camera " + a.input.device;
    throw BoardNotSeen(source, result.frames, a.board.string());
  }
  std::printf("the board was seen in %lld of %lld frames\n",
              static_cast<long long>(result.with_board),
              static_cast<long long>(result.frames));
  const Calibration& c = result.calibration;
  if (c.corners > 0) ShowNumbers(c, a.fisheye);
  ShowCoverage(c);
  if (!c.problem.empty() && !(a.force && c.corners > 0)) {
    throw Error(ErrorKind::kFailed, "no good calibration: " + c.problem);
  }
  if (!c.problem.empty()) LogWarning("written although " + c.problem);
  WriteOpenCvYaml(a.output, c.camera, Notes(c));
  std::printf("%s\n", a.output.c_str());
}

}  // namespace

void AddCalibrateCommand(CLI::App& app) {
  auto a = std::make_shared<CalibrateArguments>();
  CLI::App* command = app.add_subcommand(
      "calibrate", "Find a camera's focal length and distortion from a board before it");
  command->add_option("--data", a->input.data, "Video, folder of images, FIFO, or - for a pipe");
  AddLiveOptions(command, &a->input);
  command->add_option("--board", a->board, "Description of the board")->required();
  command->add_option("-o,--output", a->output, "Calibration to write (.yaml)")->required();
  command->add_flag("--fisheye", a->fisheye, "The lens is a fisheye (Kannala-Brandt model)");
  command
      ->add_option(
          "--terms", a->options.distortion_terms, "Distortion: 0, 2 (k1 k2), 4 (p1 p2) or 5 (k3)")
      ->capture_default_str();
  command->add_option("--views", a->options.max_views, "At most so many different views")
      ->capture_default_str();
  command->add_option("--max-rms", a->options.max_rms_px, "Refuse a fit worse than this [px]")
      ->capture_default_str();
  command->add_flag("--force", a->force, "Write a calibration that is not good, too");
  command->add_option("--progress", a->progress, "auto, line, json or none")->capture_default_str();
  command->footer(
      "Film the board for half a minute, slowly, with focus and zoom fixed: from straight above\n"
      "and tilted by 30 to 60 degrees to all sides, and so that it comes to each border of the\n"
      "picture. Sharp views that differ are chosen by the program. With a camera it says which "
      "are\n"
      "still missing, and ends when the calibration is good.\n\n"
      "Examples:\n"
      "  livemvs calibrate --camera 0 --board board.json -o camera.yaml\n"
      "  livemvs calibrate --data board.mp4 --board board.json -o camera.yaml\n"
      "  livemvs calibrate --data stills --board board.json --fisheye -o camera.yaml");
  command->callback([a] { RunCalibrate(*a); });
}

}  // namespace livemvs::app
