#pragma once

#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/options.h"
#include "livemvs/core/scene_range.h"
#include "livemvs/io/dataset.h"

namespace livemvs::app {

/// How to reconstruct and where, as the command line says it; 'run' and 'scan' share it.
struct MethodArguments {
  std::string preset = "default";
  std::vector<std::string> settings;  ///< NAME=VALUE
  std::vector<double> box;            ///< x0 y0 z0 x1 y1 z1 [scene], or empty.
  double near = 0;                    ///< [scene]; 0: not given.
  double far = 0;                     ///< [scene]; 0: not given.
  std::string search;
  int seeds = 0;        ///< 0: the preset's.
  int threads = 0;      ///< 0: all cores.
  std::string backend;  ///< Empty: the preset's.
};

void AddMethodOptions(CLI::App* command, MethodArguments* args);

/// The options of the method. @throws std::invalid_argument naming what is wrong.
Options MakeOptions(const MethodArguments& args);

/// The box of --box, if any. @throws Error (kBadInput) where it is empty.
std::optional<Box> BoxOf(const MethodArguments& args);

/// All cameras of a data set.
std::vector<PosedCamera> CamerasOf(const Dataset& dataset);

/// Where surfaces are sought, by the arguments or else by the data set.
/// @throws Error (kBadInput) where that is empty.
SceneRange RangeOf(const MethodArguments& args, const Dataset& dataset);

/// A range for people: "depths 0.2 to 1 in the box ..., from --box".
std::string Describe(const SceneRange& range);

/// Settles what depends on the data, and says so.
Options FitToData(const Options& options, const Dataset& dataset, const SceneRange& range);

/// All that runs in parallel uses as many threads while the result lives; 0: all cores.
std::optional<tbb::global_control> LimitThreads(int threads);

}  // namespace livemvs::app
