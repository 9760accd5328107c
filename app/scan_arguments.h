#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "live_input.h"
#include "live_view.h"
#include "livemvs/io/dataset.h"
#include "method_options.h"

namespace livemvs::app {

/// What 'livemvs scan' is told. What decides the result is kept in the journal, so that a scan can
/// be resumed by its folder alone.
struct ScanArguments : LiveArguments {
  std::filesystem::path poses;
  std::filesystem::path images;
  std::string calibration;
  PoseConvention convention = PoseConvention::kAuto;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = -1;
  std::int64_t step = 1;
  bool realtime = false;
  std::filesystem::path board;
  double height = 0;  ///< Of the room above the board [m]; 0: chosen.
  MethodArguments method;

  std::filesystem::path output;
  std::filesystem::path resume;
  bool finish = false;
  bool no_mesh = false;
  std::string progress = "auto";
  PageOptions view;
};

void AddScanOptions(CLI::App* command, ScanArguments* args);

/// What must be given is, and what excludes each other is not. @throws std::invalid_argument
void CheckScanArguments(const ScanArguments& args);

/// For the journal: all that decides the result. Paths become absolute.
nlohmann::json ToJson(const ScanArguments& args);

/// Sets what ToJson() wrote. @throws Error (kBadInput) naming `where` if the JSON is no such.
void FromJson(const std::string& text, const std::string& where, ScanArguments* args);

}  // namespace livemvs::app
