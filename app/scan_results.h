#pragma once

#include <filesystem>

#include "livemvs/scan/scan.h"
#include "scan_arguments.h"

namespace livemvs::app {

/// Names in the folder of a scan.
inline constexpr char kJournalName[] = "journal.lmv";
inline constexpr char kBoardName[] = "board.json";

/// Writes cloud.ply, poses.txt (TUM), camera.yaml, model.ply and statistics.json into a folder and
/// prints their paths. One that cannot be written does not keep the others from being written.
/// @throws the first failure, when all was tried.
void WriteScanResults(const std::filesystem::path& folder,
                      const ScanArguments& args,
                      const ScanSettings& settings,
                      ScanResult* result);

}  // namespace livemvs::app
