// The part of 'livemvs eval' that judges seeds rather than points.

#include "seed_report.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/picture_codec.h"
#include "livemvs/io/seed_trace.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

Image<std::uint8_t> ReadLabels(const fs::path& path, const Camera& camera) {
  const Image<std::uint16_t> values = ReadDepthPng(path);
  if (values.width() != camera.width || values.height() != camera.height) {
    throw BadInput(path.string() + ": is not of the size of the data set's frames");
  }
  Image<std::uint8_t> labels(values.width(), values.height());
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      if (values(x, y) > kAllPixelLabels) {
        throw BadInput(path.string() + ": " + std::to_string(values(x, y)) + " at (" +
                       std::to_string(x) + ", " + std::to_string(y) + ") is no sum of labels");
      }
      labels(x, y) = static_cast<std::uint8_t>(values(x, y));
    }
  }
  return labels;
}

std::vector<LabelledView> ReadLabelledViews(const fs::path& data) {
  DatasetOptions options;
  options.data = data;
  const std::unique_ptr<Dataset> dataset = OpenDataset(options);
  const fs::path folder = (fs::is_directory(data) ? data : data.parent_path()) / "labels";
  std::vector<LabelledView> views;
  for (const DatasetView& view : dataset->views()) {
    char name[32];
    std::snprintf(name, sizeof(name), "%06lld.png", static_cast<long long>(view.index));
    if (!fs::exists(folder / name)) continue;
    views.push_back(
        {view.index, view.camera, view.cam_from_world, ReadLabels(folder / name, view.camera)});
  }
  if (views.empty()) {
    throw BadInput(folder.string() +
                   ": holds no labels of frames; 'livemvs synth --labels-every N' writes them");
  }
  return views;
}

}  // namespace

void AddSeedReportOptions(CLI::App* command, SeedReportArguments* args) {
  CLI::Option* trace = command->add_option(
      "--trace", args->trace, "Judge the seeds too: what 'livemvs run --trace' wrote");
  CLI::Option* labels = command->add_option(
      "--labels", args->labels, "With --trace: data set with what makes its pixels hard");
  trace->needs(labels);
  labels->needs(trace);
  command
      ->add_option("--false-beyond",
                   args->false_beyond,
                   "With --trace: a seed that is off by more converged falsely [% of the depth]")
      ->capture_default_str();
}

FalseConvergence JudgeSeeds(const SeedReportArguments& args, const MeshSurface& surface) {
  const std::vector<SeedRecord> seeds = ReadSeedTrace(args.trace);
  FalseConvergence result =
      MeasureFalseConvergence(seeds, ReadLabelledViews(args.labels), surface, args.Options());
  if (result.judged == 0) {
    LogWarning(args.trace + ": no seed was planted in a frame with labels; is it of this data?");
  }
  return result;
}

}  // namespace livemvs::app
