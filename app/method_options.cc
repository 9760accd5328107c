#include "method_options.h"

#include <cstdio>
#include <stdexcept>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/pipeline/search_mode.h"

namespace livemvs::app {
namespace {

SceneRange UncheckedRange(const MethodArguments& args, const Dataset& dataset) {
  const std::vector<PosedCamera> cameras = CamerasOf(dataset);
  const double margin = MakeOptions(args).box_margin;
  SceneRange range;
  if (const std::optional<Box> box = BoxOf(args)) {
    range = RangeOfBox(*box, margin, cameras);
  } else if (args.near > 0 && args.far > 0) {
    range.origin = "--near and --far";
  } else if (dataset.box()) {
    range = RangeOfBox(*dataset.box(), margin, cameras);
    range.origin = "the data set's box";
  } else {
    range = DeriveRange(cameras, dataset.sparse_points());
  }
  if (args.near > 0) range.near = args.near;
  if (args.far > 0) range.far = args.far;
  range.Check();
  return range;
}

}  // namespace

void AddMethodOptions(CLI::App* command, MethodArguments* args) {
  command->add_option("--preset", args->preset, "default, or paper: the method as published");
  command->add_option("--box", args->box, "Keep what is inside of x0 y0 z0 x1 y1 z1 [scene units]")
      ->expected(6);
  command->add_option("--near", args->near, "Least depth [scene units]")
      ->check(CLI::PositiveNumber);
  command->add_option("--far", args->far, "Largest depth [scene units]")
      ->check(CLI::PositiveNumber);
  command->add_option(
      "--search", args->search, "window, full (for wide steps between frames), or auto");
  command->add_option("--seeds", args->seeds, "Seeds kept alive (250000)")
      ->check(CLI::PositiveNumber);
  command->add_option("--threads", args->threads, "Worker threads (all cores)")
      ->check(CLI::PositiveNumber);
  command->add_option(
      "--backend", args->backend, "cpu, cuda (an NVIDIA GPU), or auto: that or else the CPU (cpu)");
  command->add_option("--set", args->settings, "Any option of the method, NAME=VALUE; repeatable");
}

Options MakeOptions(const MethodArguments& args) {
  Options options = OptionsFromPreset(args.preset);
  for (const std::string& setting : args.settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("--set " + setting + ": must be NAME=VALUE");
    }
    SetOption(&options, setting.substr(0, equals), setting.substr(equals + 1));
  }
  if (args.seeds > 0) options.max_seeds = args.seeds;
  if (args.threads > 0) options.threads = args.threads;
  if (!args.search.empty()) SetOption(&options, "search", args.search);
  if (!args.backend.empty()) SetOption(&options, "backend", args.backend);
  options.Check();
  return options;
}

std::optional<Box> BoxOf(const MethodArguments& args) {
  if (args.box.empty()) return std::nullopt;
  Box box;
  box.min = {args.box[0], args.box[1], args.box[2]};
  box.max = {args.box[3], args.box[4], args.box[5]};
  SceneRange range;
  range.box = box;
  range.near = 1;
  range.far = 2;
  try {
    range.Check();
  } catch (const std::invalid_argument& e) {
    throw BadInput(e.what());
  }
  return box;
}

std::vector<PosedCamera> CamerasOf(const Dataset& dataset) {
  std::vector<PosedCamera> cameras;
  for (const DatasetView& view : dataset.views()) {
    cameras.push_back({view.camera, view.cam_from_world});
  }
  return cameras;
}

// An empty range is bad input, wherever it comes from.
SceneRange RangeOf(const MethodArguments& args, const Dataset& dataset) {
  try {
    return UncheckedRange(args, dataset);
  } catch (const std::invalid_argument& e) {
    throw BadInput(e.what());
  }
}

std::string Describe(const SceneRange& range) {
  char text[256];
  std::snprintf(text, sizeof(text), "depths %.4g to %.4g", range.near, range.far);
  std::string description = text;
  if (range.box) {
    const Box& b = *range.box;
    std::snprintf(text,
                  sizeof(text),
                  " in the box (%.4g %.4g %.4g) to (%.4g %.4g %.4g)",
                  b.min.x(),
                  b.min.y(),
                  b.min.z(),
                  b.max.x(),
                  b.max.y(),
                  b.max.z());
    description += text;
  }
  return description + ", from " + range.origin;
}

Options FitToData(const Options& options, const Dataset& dataset, const SceneRange& range) {
  LogInfo("looking for surfaces at " + Describe(range));
  Options fitted = ResolveSearch(CamerasOf(dataset), range, options);
  LogInfo(fitted.search == Search::kFull
              ? "searching whole epipolar lines: the steps between frames are wide"
              : "searching near the prediction: the steps between frames are small");
  return fitted;
}

std::optional<tbb::global_control> LimitThreads(int threads) {
  if (threads <= 0) return std::nullopt;
  return std::optional<tbb::global_control>(std::in_place,
                                            tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
}

}  // namespace livemvs::app
