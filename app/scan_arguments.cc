#include "scan_arguments.h"

#include <map>
#include <stdexcept>

#include "livemvs/core/error.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string Absolute(const fs::path& path) {
  if (path.empty() || path == "-") return path.string();
  return fs::absolute(path).lexically_normal().string();
}

// One list of what is kept, for writing and reading: visit(name, field).
template <typename Arguments, typename Visit>
void VisitKept(Arguments& a, Visit&& visit) {
  visit("device", a.device);
  visit("mode", a.mode);
  visit("controls", a.controls);
  visit("data", a.data);
  visit("poses", a.poses);
  visit("images", a.images);
  visit("calibration", a.calibration);
  visit("pose_convention", a.convention);
  visit("first_frame", a.first_frame);
  visit("last_frame", a.last_frame);
  visit("step", a.step);
  visit("pipe_format", a.pipe_format);
  visit("realtime", a.realtime);
  visit("board", a.board);
  visit("height", a.height);
  visit("preset", a.method.preset);
  visit("set", a.method.settings);
  visit("box", a.method.box);
  visit("near", a.method.near);
  visit("far", a.method.far);
  visit("search", a.method.search);
  visit("max_seeds", a.method.seeds);
}

const std::map<std::string, PoseConvention>& Conventions() {
  static const std::map<std::string, PoseConvention> conventions = {
      {"auto", PoseConvention::kAuto},
      {"cam-from-world", PoseConvention::kCamFromWorld},
      {"world-from-cam", PoseConvention::kWorldFromCam},
      {"world-from-cam-opengl", PoseConvention::kWorldFromCamOpenGl}};
  return conventions;
}

void AddSourceOptions(CLI::App* command, ScanArguments* args) {
  AddLiveOptions(command, args);
  command->add_option("--data", args->data, "Video, data set folder, FIFO, or - for a pipe");
  command->add_option("--board", args->board, "Description of the printed sheet (JSON)");
  command->add_option(
      "--calibration", args->calibration, "OpenCV YAML file, or fx,fy,cx,cy[,k1,k2,p1,p2[,k3...]]");
  command->add_option("--poses", args->poses, "Pose file, where there is no board");
  command->add_option("--images", args->images, "Folder of the images, where not the usual one");
  command->add_option("--pose-convention", args->convention, "Of the pose file, see 'run'")
      ->transform(CLI::CheckedTransformer(Conventions()));
  command->add_option("--first-frame", args->first_frame, "First frame to use")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--last-frame", args->last_frame, "Last frame to use");
  command->add_option("--step", args->step, "Use every n-th frame")->check(CLI::PositiveNumber);
  command->add_flag("--realtime",
                    args->realtime,
                    "Play a recording at its own pace; frames that come too late are dropped");
}

}  // namespace

void AddScanOptions(CLI::App* command, ScanArguments* args) {
  AddSourceOptions(command, args);
  AddPageOptions(command, &args->view);
  command->add_option("--height", args->height, "Of the room above the board [m]")
      ->check(CLI::PositiveNumber);
  command->add_option("-o,--output", args->output, "Folder to write; it must not hold a scan yet");
  command->add_option("--resume", args->resume, "Folder of a scan to go on with");
  command->add_flag("--no-mesh", args->no_mesh, "Write the cloud alone");
  command->add_flag("--finish", args->finish, "With --resume: only write what the journal holds");
  AddMethodOptions(command, &args->method);
  command->add_option("--progress", args->progress, "auto, line, json or none");
}

void CheckScanArguments(const ScanArguments& args) {
  if (!args.resume.empty()) {
    if (!args.output.empty() || !args.data.empty() || !args.device.empty()) {
      throw std::invalid_argument(
          "--resume DIR takes source and output from DIR: leave out --data, --camera and -o");
    }
    return;
  }
  if (args.finish) throw std::invalid_argument("--finish needs --resume DIR");
  if (args.output.empty())
    throw std::invalid_argument("-o DIR is missing: where to write the scan");
  if (args.data.empty() == args.device.empty()) {
    throw std::invalid_argument("give either --camera NUMBER or --data VIDEO");
  }
  if (args.board.empty() && !args.device.empty()) {
    throw std::invalid_argument("--camera needs --board: the sheet says where the camera is");
  }
}

json ToJson(const ScanArguments& args) {
  json out;
  VisitKept(args, [&](const char* name, const auto& field) {
    using Field = std::decay_t<decltype(field)>;
    if constexpr (std::is_same_v<Field, fs::path>) {
      out[name] = Absolute(field);
    } else if constexpr (std::is_same_v<Field, PoseConvention>) {
      out[name] = static_cast<int>(field);
    } else {
      out[name] = field;
    }
  });
  std::error_code error;
  if (fs::exists(args.calibration, error)) out["calibration"] = Absolute(args.calibration);
  return out;
}

void FromJson(const std::string& text, const std::string& where, ScanArguments* args) {
  try {
    const json in = json::parse(text).at("arguments");
    VisitKept(*args, [&](const char* name, auto& field) {
      using Field = std::decay_t<decltype(field)>;
      if constexpr (std::is_same_v<Field, fs::path>) {
        field = in.at(name).get<std::string>();
      } else if constexpr (std::is_same_v<Field, PoseConvention>) {
        const int value = in.at(name).get<int>();
        if (value < 0 || value > static_cast<int>(PoseConvention::kWorldFromCamOpenGl)) {
          throw BadInput(where + ": unknown pose convention");
        }
        field = static_cast<PoseConvention>(value);
      } else {
        in.at(name).get_to(field);
      }
    });
  } catch (const json::exception& e) {
    throw BadInput(where + ": does not say how the scan was made (" + e.what() + ")");
  }
  if (args->step < 1 || args->first_frame < 0) throw BadInput(where + ": frames make no sense");
  if (!args->method.box.empty() && args->method.box.size() != 6) {
    throw BadInput(where + ": the box does not have 6 numbers");
  }
}

}  // namespace livemvs::app
