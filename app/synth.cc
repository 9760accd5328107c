// livemvs synth: renders a sequence with known truth.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.h"
#include "interrupt.h"
#include "livemvs/synth/export.h"
#include "livemvs/synth/printed_sheet.h"
#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/board_sheet.h"
#include "progress.h"

namespace livemvs::app {
namespace {

// What the command line says; numbers that are not given keep the scene's own value.
struct SynthArguments {
  SceneOptions scene;
  std::filesystem::path board;
  std::string path;
  int frames = 0;
  double fps = 30;
  std::string size = "960x720";
  double focal_px = 0;
  std::vector<double> distortion;
  bool fisheye = false;
  double arc_deg = NAN, start_deg = NAN, radius = NAN, height = NAN;
  double wobble = 1;
  SequenceOptions sequence;
  bool blur = false;
  double shutter = 0.5;
  ExportOptions out;
  bool no_mesh = false;
  std::string progress = "auto";
};

Camera CameraOf(const SynthArguments& a) {
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(a.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 ||
      height < 16 || width > 8192 || height > 8192) {
    throw std::invalid_argument("--size " + a.size + ": not WIDTHxHEIGHT, 16 to 8192 pixels each");
  }
  Camera camera = SyntheticCamera(width, height);
  if (a.focal_px > 0) camera.fx = camera.fy = a.focal_px;
  if (!a.distortion.empty()) {
    const std::size_t most = a.fisheye ? 4 : 8;
    if (a.distortion.size() > most) {
      throw std::invalid_argument("--distortion: more than " + std::to_string(most) + " numbers");
    }
    camera.model = a.fisheye ? CameraModel::kKannalaBrandt : CameraModel::kBrownConrady;
    std::copy(a.distortion.begin(), a.distortion.end(), camera.distortion.begin());
  } else if (a.fisheye) {
    camera.model = CameraModel::kKannalaBrandt;
  }
  return camera;
}

PathOptions PathOf(const SynthArguments& a) {
  PathOptions path = DefaultPath(a.scene.name);
  if (!a.path.empty()) path.kind = PathKindFromName(a.path);
  if (a.frames > 0) path.frames = a.frames;
  path.frames_per_second = a.fps;
  path.seed = a.scene.seed;
  path.wobble = a.wobble;
  if (!std::isnan(a.arc_deg)) path.arc_deg = a.arc_deg;
  if (!std::isnan(a.start_deg)) path.start_deg = a.start_deg;
  if (!std::isnan(a.radius)) path.radius = a.radius;
  if (!std::isnan(a.height)) path.height = a.height;
  return path;
}

// Prints the board on the sheet of the scenes that have one, and describes it in the folder.
void PrintBoard(SynthArguments* a) {
  if (a->scene.name != "sheet" && a->scene.name != "board") return;
  constexpr int kPixelsPerSquare = 96;  // a multiple of the cells of most markers
  const Board board = a->board.empty() ? Board() : ReadBoard(a->board);
  a->scene.sheet = std::make_shared<const synth::PrintedSheet>(DrawBoard(board, kPixelsPerSquare),
                                                               board.width());
  std::filesystem::create_directories(a->out.folder);
  WriteBoard(a->out.folder / "board.json", board);
}

void RunSynth(SynthArguments a, const std::string& command) {
  PrintBoard(&a);
  a.scene.Check();
  a.sequence.path = PathOf(a);
  a.sequence.camera = CameraOf(a);
  if (a.blur) a.sequence.blur = a.shutter;
  a.sequence.Check();
  a.out.Check();
  a.out.mesh = !a.no_mesh;
  a.out.command = command;
  const SyntheticScene scene(a.scene);
  Progress progress(ParseProgressMode(a.progress));
  const int frames = a.sequence.path.frames;
  a.out.progress = [&progress, frames](int done) {
    progress.Show({.stage = "rendering", .done = done, .total = frames});
    return !Interrupted();
  };
  CatchInterrupts();
  const auto written = ExportSequence(scene, a.sequence, a.out);
  progress.Finish();
  for (const std::filesystem::path& path : written) std::printf("%s\n", path.c_str());
  if (Interrupted()) throw CLI::RuntimeError(kExitInterrupted);
}

void AddCameraOptions(CLI::App* command, SynthArguments* a) {
  command->add_option("--size", a->size, "Image size [px]")->capture_default_str();
  command->add_option("--focal", a->focal_px, "Focal length [px]; default: 0.95 of the width");
  command
      ->add_option("--distortion",
                   a->distortion,
                   "Lens distortion k1,k2[,p1,p2[,k3[,k4,k5,k6]]]; with --fisheye: k1,k2,k3,k4")
      ->delimiter(',');
  command->add_flag("--fisheye", a->fisheye, "The lens is a fisheye (Kannala-Brandt)");
  command->add_option("--noise", a->sequence.noise_sigma, "Sensor noise [grey levels]");
  command->add_flag("--blur", a->blur, "Motion blur");
  command->add_option("--shutter", a->shutter, "With --blur: part of the time it is open")
      ->capture_default_str();
  command->add_option("--exposure-variation",
                      a->sequence.exposure_variation,
                      "Relative change of brightness that comes and goes, 0 to 0.9");
  command->add_option("--spp", a->sequence.samples_per_pixel, "Samples per pixel")
      ->capture_default_str();
}

void AddPathOptions(CLI::App* command, SynthArguments* a) {
  command->add_option("--path", a->path, "orbit, hemisphere or walk; default: the scene's own");
  command->add_option("--frames", a->frames, "Number of frames; default: the scene's own");
  command->add_option("--fps", a->fps, "Frames per second")->capture_default_str();
  command->add_option("--arc", a->arc_deg, "Angle the camera goes around [degrees]");
  command->add_option("--start", a->start_deg, "Azimuth where it starts [degrees]");
  command->add_option("--radius", a->radius, "Distance from the target [m]");
  command->add_option("--height", a->height, "Height above the target [m]");
  command->add_option("--wobble", a->wobble, "Unrest of the hand; 0: none")->capture_default_str();
}

void AddOutputOptions(CLI::App* command, SynthArguments* a) {
  command->add_option("-o,--output", a->out.folder, "Folder to write")->required();
  command->add_flag("--images", a->out.images, "Write PNG images instead of a video");
  command->add_option("--crf", a->out.crf, "Video quality: 0 lossless ... 51 worst")
      ->capture_default_str();
  command->add_option("--encoder-preset", a->out.preset, "Speed of x264")->capture_default_str();
  command->add_option(
      "--depth-every", a->out.depth_every, "Write the true depth of every N-th frame");
  command->add_option("--labels-every",
                      a->out.labels_every,
                      "Write what makes pixels hard, of every N-th frame, for 'livemvs eval'");
  command->add_option("--progress", a->progress, "auto, line, json or none")->capture_default_str();
  command->add_flag("--no-mesh", a->no_mesh, "Do not write the true surface");
}

// The command line as it was given, for README.txt, without the folder of the program.
std::string CommandLine(const CLI::App& command) {
  std::string line = "livemvs " + command.get_name();
  for (const CLI::Option* option : command.parse_order()) {
    line += " " + option->get_name();
    if (option->get_expected_max() == 0) continue;
    std::string values;
    for (const std::string& value : option->results()) {
      values += (values.empty() ? "" : ",") + value;
    }
    line += " " + values;
  }
  return line;
}

}  // namespace

void AddSynthCommand(CLI::App& app) {
  auto arguments = std::make_shared<SynthArguments>();
  CLI::App* command = app.add_subcommand(
      "synth", "Render a sequence with exact poses, depth and mesh, as a data set folder");
  command
      ->add_option(
          "--scene",
          arguments->scene.name,
          "table (still life), relief, house, room, plane, hazards (plain, "
          "repetitive, glossy and occluding things), bench (a desk), sheet (a printed board) "
          "or board (the still life on it)")
      ->capture_default_str();
  command->add_option(
      "--board",
      arguments->board,
      "What is printed in the scenes sheet and board: a description of 'livemvs board'");
  command->add_option("--seed", arguments->scene.seed, "Of textures, hand and noise")
      ->capture_default_str();
  AddPathOptions(command, arguments.get());
  AddCameraOptions(command, arguments.get());
  AddOutputOptions(command, arguments.get());
  command->footer(
      "The folder opens with 'livemvs run --data FOLDER'; its README.txt says what is in it.\n\n"
      "Examples:\n"
      "  livemvs synth -o still-life\n"
      "  livemvs synth --scene table --frames 180 --arc 120 --noise 2 --crf 23 -o sample\n"
      "  livemvs synth --scene relief --size 640x480 --images -o temple      (312 views)\n"
      "  livemvs synth --scene room --noise 2 --blur --distortion -0.2,0.05 -o walk\n"
      "  livemvs synth --scene plane --frames 60 --depth-every 10 -o plane\n"
      "  livemvs synth --scene board --noise 2 --blur --distortion -0.2,0.05 -o board\n"
      "  livemvs synth --scene hazards --noise 2 --labels-every 5 -o hazards");
  command->callback([arguments, command] { RunSynth(*arguments, CommandLine(*command)); });
}

}  // namespace livemvs::app
