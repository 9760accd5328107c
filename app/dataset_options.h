#pragma once

#include <CLI/CLI.hpp>

#include "livemvs/io/dataset.h"

namespace livemvs::app {

/// Adds --data and its companions to a command.
void AddDatasetOptions(CLI::App* command, DatasetOptions* options, bool required = true);

}  // namespace livemvs::app
