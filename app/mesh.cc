#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cloud_output.h"
#include "commands.h"
#include "dataset_options.h"
#include "interrupt.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/ply.h"
#include "livemvs/mesh/build_mesh.h"
#include "mesh_input.h"
#include "output_check.h"
#include "progress.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

struct MeshArguments {
  fs::path input;
  DatasetOptions dataset;
  fs::path output;
  fs::path stats;
  std::string progress = "auto";
  MeshOptions options;
};

void Run(const MeshArguments& args) {
  args.options.Check();
  CatchInterrupts();
  MeshInput input = ReadMeshInput(args.input);
  if (!args.dataset.data.empty()) {
    input.cameras = CamerasOf(OpenDataset(args.dataset)->views());
  }
  MeshWatch watch;
  watch.stop = Interrupted;
  watch.progress = [](const std::string& stage, double share) {
    std::fprintf(stderr, "%s %.0f%%\n", stage.c_str(), 100 * share);
  };
  const BuiltMesh built = BuildMesh(input.cloud, input.cameras, args.options, watch);
  WritePly(args.output, built.mesh);
  const MeshStatistics& s = built.statistics;
  std::printf(
      "%zu points (%zu seen), voxel %g, %d levels, %zu voxels; %zu vertices, %zu faces; cut %.1f "
      "s, surface %.1f s; "
      "specks %zu unsupported %zu sideways %zu; bad %zu pinched %zu intersections %zu border %zu\n",
      s.points,
      s.points_seen,
      s.voxel,
      s.levels,
      s.voxels,
      built.mesh.vertices.size(),
      built.mesh.faces.size(),
      s.seconds_cut,
      s.seconds_surface,
      s.trimmed.specks,
      s.trimmed.unsupported_faces,
      s.trimmed.sideways_faces,
      s.bad_edges,
      s.pinched,
      s.intersections,
      s.border_edges);
}

}  // namespace

void AddMeshCommand(CLI::App& app) {
  auto args = std::make_shared<MeshArguments>();
  CLI::App* command = app.add_subcommand("mesh", "Make a surface of a cloud");
  command->add_option("CLOUD", args->input, "Cloud (.ply), or the folder of a scan")->required();
  command->add_option("--data", args->dataset.data, "Data set that the cloud was made of");
  command->add_option("-o,--output", args->output, "Mesh to write")->required();
  MeshOptions& o = args->options;
  command->add_option("--resolution", o.resolution, "Side of the finest voxels [scene]");
  command->add_option("--memory", o.memory_mb, "Memory limit [MB]");
  command->add_flag("--watertight", o.watertight, "Close the surface");
  command->add_option("--free_gain", o.free_gain);
  command->add_option("--free_limit", o.free_limit);
  command->add_option("--inside_gain", o.inside_gain);
  command->add_option("--inside_limit", o.inside_limit);
  command->add_option("--inside_prior", o.inside_prior);
  command->add_option("--vote_gain", o.vote_gain);
  command->add_option("--rho_min", o.rho_min);
  command->add_option("--lambda", o.lambda);
  command->add_option("--reach", o.reach);
  command->add_option("--smoothing", o.smoothing);
  command->add_option("--rounds", o.smoothing_rounds);
  command->add_option("--support", o.support);
  command->add_option("--held", o.held);
  command->add_option("--facing", o.least_facing);
  command->add_option("--fairing", o.fairing_rounds);
  command->callback([args] { Run(*args); });
}

}  // namespace livemvs::app
