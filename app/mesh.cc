#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cloud_output.h"
#include "commands.h"
#include "dataset_options.h"
#include "interrupt.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset.h"
#include "livemvs/mesh/build_mesh.h"
#include "livemvs/mesh/color_mesh.h"
#include "mesh_input.h"
#include "mesh_output.h"
#include "method_options.h"
#include "output_check.h"
#include "progress.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

constexpr char kMeshExamples[] =
    "The surface runs where the points are, leaves empty what lies between them and the cameras\n"
    "that saw them, and is open where nothing was seen. The cameras are those of --data, by the\n"
    "frame that each point was seen in, or of the scan. Without them the points' normals stand "
    "in.\n"
    "Lengths are in units of the scene; see docs/meshing.md. The ending of the output says its "
    "form:\n"
    ".glb, which most programs open, .obj or .ply.\n"
    "\n"
    "Examples:\n"
    "  livemvs mesh scan.ply --data scan/ -o model.glb\n"
    "  livemvs mesh mug/ -o mug.obj                    (the folder of a scan)\n"
    "  livemvs mesh scan.ply --data scan/ --resolution 0.002 --faces 50000 -o model.ply\n"
    "  livemvs mesh scan.ply --data scan/ --whole -o whole.ply\n"
    "\n"
    "Exit codes: 0 done, 1 failed, 2 usage, 3 bad input, 4 out of resources, 130 interrupted\n"
    "(nothing is written).";

struct MeshArguments {
  fs::path input;
  DatasetOptions dataset;
  fs::path output;
  fs::path stats;
  std::string progress = "auto";
  int threads = 0;
  int color_frames = 60;
  MeshOptions options;
};

/// Colours the mesh from the sharpest picture of each of so many stretches of the film.
void ColorFromFrames(const MeshArguments& args,
                     Dataset* dataset,
                     Progress* progress,
                     BuiltMesh* built) {
  const std::size_t total = dataset->views().size();
  const std::size_t stretches = std::min(total, static_cast<std::size_t>(args.color_frames));
  if (stretches == 0) return;
  MeshColorizer colorizer(built->mesh, 2 * built->statistics.voxel);
  std::optional<PosedFrame> best;
  double sharpness = -1;
  std::size_t stretch = 0, count = 0;
  const auto use_best = [&] {
    if (best) colorizer.AddFrame(*best);
    best.reset();
    sharpness = -1;
  };
  while (std::optional<PosedFrame> frame = dataset->Next()) {
    if (Interrupted()) throw MeshInterrupted();
    if (count++ * stretches / total != stretch) {
      use_best();
      stretch = (count - 1) * stretches / total;
    }
    const double s = SharpnessOf(*frame->picture);
    if (s > sharpness) {
      sharpness = s;
      best = std::move(frame);
    }
    progress->ShowShare("colour", static_cast<double>(count) / static_cast<double>(total));
  }
  use_best();
  if (built->mesh.colors.empty()) built->mesh.colors.resize(built->mesh.vertices.size());
  built->mesh.colors = colorizer.Take(std::move(built->mesh.colors));
}

BuiltMesh Build(const MeshArguments& args, MeshInput* input, Dataset* dataset, Progress* progress) {
  if (dataset != nullptr) input->cameras = CamerasOf(dataset->views());
  MeshWatch watch;
  watch.stop = Interrupted;
  watch.progress = [progress](const std::string& stage, double share) {
    progress->ShowShare(stage, share);
  };
  BuiltMesh built = BuildMesh(input->cloud, input->cameras, args.options, watch);
  if (dataset != nullptr) ColorFromFrames(args, dataset, progress, &built);
  return built;
}

void Run(const MeshArguments& args) {
  args.options.Check();
  std::vector<Output> outputs = MeshOutputs(args.output);
  outputs.push_back({args.stats, "the statistics", "", ""});
  const std::optional<tbb::global_control> thread_limit = LimitThreads(args.threads);
  Progress progress(ParseProgressMode(args.progress));
  CheckOutputs(outputs, {args.input, args.dataset.data, args.dataset.poses, args.dataset.camera});
  CatchInterrupts();
  try {
    MeshInput input = ReadMeshInput(args.input);
    DatasetOptions options = args.dataset;
    options.cancelled = Interrupted;
    const std::unique_ptr<Dataset> dataset = options.data.empty() ? nullptr : OpenDataset(options);
    const BuiltMesh built = Build(args, &input, dataset.get(), &progress);
    progress.Finish();
    WarnOfMesh(built.statistics, args.options);
    WriteMesh(args.output, built.mesh);
    PrintMesh(built, args.output);
    if (args.stats.empty()) return;
    nlohmann::json statistics = MeshJson(built);
    AddResources(&statistics);
    WriteStatistics(args.stats, statistics);
  } catch (const MeshInterrupted&) {
    progress.Finish();
    LogWarning("interrupted; no mesh was written");
    throw CLI::RuntimeError(kExitInterrupted);
  }
}

void AddSurfaceOptions(CLI::App* command, MeshOptions* o) {
  command
      ->add_option("--resolution",
                   o->resolution,
                   "Side of the finest voxels [scene]; 0: the points' spacing")
      ->capture_default_str();
  command->add_option("--memory", o->memory_mb, "What the grids may take [MB]; voxels grow to fit")
      ->capture_default_str();
  command->add_option("--faces", o->faces, "Decimate to at most so many triangles");
  command->add_flag("--whole",
                    o->whole_surface,
                    "Keep all of the surface that was cut, also where nothing was seen");
  command->add_option("--support", o->support, "Open the surface so far from every point [voxel]")
      ->capture_default_str();
  command->add_option("--smoothing", o->smoothing, "Weight of smoothness against the points")
      ->capture_default_str();
  command
      ->add_option("--specks",
                   o->least_component,
                   "Leave out parts of less than this share of the largest's area")
      ->capture_default_str();
}

}  // namespace

void AddMeshCommand(CLI::App& app) {
  auto args = std::make_shared<MeshArguments>();
  CLI::App* command = app.add_subcommand("mesh", "Make a surface of a cloud or scan");
  command->footer(kMeshExamples);
  command->add_option("CLOUD", args->input, "Cloud (.ply, .ply.gz), or the folder of a scan")
      ->required();
  AddDatasetOptions(command, &args->dataset)->required(false);
  command->add_option("-o,--output", args->output, "Mesh to write: .glb, .obj or .ply")->required();
  AddSurfaceOptions(command, &args->options);
  command
      ->add_option("--color-frames",
                   args->color_frames,
                   "Pictures of --data to take colours from, at most; 0: from the points")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  command->add_option("--threads", args->threads, "Threads; 0: as many as there are cores")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--stats", args->stats, "Statistics to write (JSON)");
  command->add_option("--progress", args->progress, "auto, line, json or none");
  command->callback([args] { Run(*args); });
}

}  // namespace livemvs::app
