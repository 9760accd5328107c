#include "live_input.h"

#include <charconv>
#include <stdexcept>

#include "interrupt.h"
#include "livemvs/io/camera_source.h"
#include "livemvs/io/pipe_source.h"

namespace livemvs::app {
namespace {

PipeOptions PipeOptionsOf(const LiveArguments& args) {
  PipeOptions options;
  options.cancelled = Interrupted;
  options.open_timeout = args.patience;
  if (args.pipe_format.empty()) return options;
  const std::size_t colon = args.pipe_format.find(':');
  const std::size_t times = args.pipe_format.find('x', colon == std::string::npos ? 0 : colon);
  if (colon == std::string::npos || times == std::string::npos) {
    throw std::invalid_argument("--pipe-format " + args.pipe_format +
                                ": must be FORMAT:WIDTHxHEIGHT, as yuyv422:640x480");
  }
  const char* text = args.pipe_format.data();
  std::from_chars(text + colon + 1, text + times, options.width);
  std::from_chars(text + times + 1, text + args.pipe_format.size(), options.height);
  options.format = args.pipe_format.substr(0, colon);
  return options;
}

}  // namespace

void AddLiveOptions(CLI::App* command, LiveArguments* args) {
  command->add_option("--camera", args->device, "Camera: its number or path (see 'cameras')");
  command->add_option("--mode", args->mode, "Mode of the camera, as 1280x720@30:mjpeg");
  command
      ->add_option("--controls",
                   args->controls,
                   "lock (exposure, focus and white balance stay as they are) or auto")
      ->check(CLI::IsMember({"lock", "auto"}));
  command->add_option("--pipe-format",
                      args->pipe_format,
                      "Of raw frames from a pipe: yuyv422, nv12, yuv420p or gray, as gray:640x480");
  command->add_option("--patience", args->patience, "Seconds to wait for a lost camera (10)")
      ->check(CLI::PositiveNumber);
}

bool IsLive(const LiveArguments& args) { return !args.device.empty() || IsPipe(args.data); }

std::unique_ptr<LiveSource> OpenLive(const LiveArguments& args) {
  if (args.device.empty()) return OpenPipe(args.data, PipeOptionsOf(args));
  return OpenCamera(args.device,
                    {.mode = ParseMode(args.mode), .lock_controls = args.controls == "lock"});
}

}  // namespace livemvs::app
