#pragma once

#include <CLI/CLI.hpp>

namespace livemvs::app {

/// Exit codes of the program.
enum ExitCode {
  kExitDone = 0,
  kExitFailed = 1,
  kExitUsage = 2,
  kExitBadInput = 3,
  kExitOutOfResources = 4,
  kExitInterrupted = 130,
};

/// Each command adds its sub-command with its options to the application. The callback does the
/// work; it reports failures by throwing livemvs::Error, std::invalid_argument or
/// CLI::RuntimeError(exit code).
void AddRunCommand(CLI::App& app);
void AddScanCommand(CLI::App& app);
void AddCamerasCommand(CLI::App& app);
void AddInfoCommand(CLI::App& app);
void AddSynthCommand(CLI::App& app);
void AddEvalCommand(CLI::App& app);
void AddMeshCommand(CLI::App& app);
void AddDepthCheckCommand(CLI::App& app);
void AddRenderCommand(CLI::App& app);
void AddViewCommand(CLI::App& app);
void AddBoardCommand(CLI::App& app);
void AddCalibrateCommand(CLI::App& app);
void AddTrackCommand(CLI::App& app);
void AddExportCommand(CLI::App& app);

}  // namespace livemvs::app
