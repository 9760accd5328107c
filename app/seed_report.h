#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "livemvs/eval/false_convergence.h"

namespace livemvs::app {

/// What 'livemvs eval' is told about seeds.
struct SeedReportArguments {
  std::string trace;        ///< Empty: no report.
  std::string labels;       ///< Data set folder with labels/.
  double false_beyond = 1;  ///< [% of the depth]

  FalseConvergenceOptions Options() const { return {.tolerance = false_beyond / 100}; }
};

void AddSeedReportOptions(CLI::App* command, SeedReportArguments* args);

/// Reads trace and labels and judges the seeds by the true surface.
/// @throws Error (kBadInput) naming the file and what is wrong with it.
FalseConvergence JudgeSeeds(const SeedReportArguments& args, const MeshSurface& surface);

}  // namespace livemvs::app
