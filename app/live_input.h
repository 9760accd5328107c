#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "livemvs/io/live_source.h"

namespace livemvs::app {

/// Where pictures come from that do not wait.
struct LiveArguments {
  std::string device;    ///< Number or path of a camera; empty: `data` is used.
  std::string mode;      ///< Of the camera: "1280x720@30:mjpeg"; empty: chosen.
  std::string controls;  ///< "lock" or "auto": exposure, focus and white balance.
  std::filesystem::path data;
  std::string pipe_format;  ///< "yuyv422:640x480"; empty: found out.
  double patience = 10;     ///< [s]
};

/// Adds --camera, --mode, --controls, --pipe-format and --patience.
void AddLiveOptions(CLI::App* command, LiveArguments* args);

/// Whether the arguments name a camera or a pipe, not a recording.
bool IsLive(const LiveArguments& args);

/// Opens the camera or pipe. @throws Error (kBadInput) naming it and the remedy.
std::unique_ptr<LiveSource> OpenLive(const LiveArguments& args);

}  // namespace livemvs::app
