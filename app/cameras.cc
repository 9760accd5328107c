#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "livemvs/io/camera_modes.h"

namespace livemvs::app {
namespace {

// The modes of a device: one line for each format and size, with its rates.
void PrintModes(const CameraDevice& camera) {
  std::string open;
  for (const CameraMode& mode : camera.modes) {
    char size[64];
    std::snprintf(size, sizeof(size), "%s %dx%d", mode.format.c_str(), mode.width, mode.height);
    if (size != open) std::printf("%s    %-20s", open.empty() ? "" : "\n", size);
    std::printf(" %.4g Hz", mode.rate);
    open = size;
  }
  std::printf("%s\n", camera.modes.empty() ? "    no mode that can be read" : "");
}

void Cameras(bool as_json) {
  const std::vector<CameraDevice> cameras = ListCameras();
  if (as_json) {
    nlohmann::json out = nlohmann::json::array();
    for (const CameraDevice& camera : cameras) {
      nlohmann::json modes = nlohmann::json::array();
      for (const CameraMode& mode : camera.modes) modes.push_back(ToString(mode));
      out.push_back(
          {{"path", camera.path}, {"name", camera.name}, {"bus", camera.bus}, {"modes", modes}});
    }
    std::printf("%s\n", out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  } else {
    for (const CameraDevice& camera : cameras) {
      std::printf("%s  %s (%s)\n", camera.path.c_str(), camera.name.c_str(), camera.bus.c_str());
      PrintModes(camera);
    }
  }
  if (!cameras.empty()) return;
  std::fprintf(stderr,
               "no camera found: none is plugged in, or its /dev/video* may not be opened (the "
               "group 'video' may)\n");
  throw CLI::RuntimeError(kExitFailed);
}

}  // namespace

void AddCamerasCommand(CLI::App& app) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("cameras", "List cameras and their modes");
  command->add_flag("--json", *as_json, "For programs");
  command->footer(
      "Use one with: livemvs scan --camera 0 --mode 1280x720@30:mjpeg ...\n\n"
      "Exit codes: 0 there are some, 1 there is none.");
  command->callback([as_json] { Cameras(*as_json); });
}

}  // namespace livemvs::app
