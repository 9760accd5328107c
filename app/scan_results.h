#pragma once

#include <filesystem>

#include "livemvs/scan/scan.h"
#include "scan_arguments.h"

namespace livemvs::app {

/// Names in the folder of a scan.
inline constexpr char kJournalName[] = "journal.lmv";
inline constexpr char kBoardName[] = "board.json";
inline constexpr char kModelName[] = "model.glb";

/// Writes cloud.ply, poses.txt (TUM), camera.yaml, model.glb and statistics.json into a folder and
/// prints their paths. One that cannot be written does not keep the others from being written. A
/// signal while the mesh is made leaves it out.
/// @return Whether one did.
/// @throws the first failure, when all was tried.
bool WriteScanResults(const std::filesystem::path& folder,
                      const ScanArguments& args,
                      const ScanSettings& settings,
                      ScanResult* result);

}  // namespace livemvs::app
