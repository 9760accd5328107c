#pragma once

#include <CLI/CLI.hpp>

#include "livemvs/io/dataset.h"

namespace livemvs::app {

/// Adds --data and its companions to a command. @return --data, which is required.
CLI::Option* AddDatasetOptions(CLI::App* command, DatasetOptions* options);

}  // namespace livemvs::app
