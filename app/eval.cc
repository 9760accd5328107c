#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/eval/report.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/picture_codec.h"
#include "model_input.h"
#include "seed_report.h"

namespace livemvs::app {
namespace {

constexpr char kEvalExamples[] =
    "A distance is 'within' a limit where it is less. Accuracy: share of the cloud's points "
    "within\n"
    "it of the reference. Completeness: share of the reference's surface within it of a point.\n"
    "With --data, only surface counts that enough cameras of the data set saw: at least 4 px\n"
    "inside the image, and with nothing in between. By default 5 of every fifth camera.\n"
    "\n"
    "With --trace and --labels, also how many of the seeds that were planted on textureless,\n"
    "occluded, repetitive, specular ... pixels converged, and how many of them to a wrong depth.\n"
    "Only seeds of frames that have labels count; pixels with two labels count under both.\n"
    "A false one that sits at the depth of another surface in its 5 x 5 patch is 'beside' an "
    "edge;\n"
    "the rest are phantoms.\n"
    "\n"
    "Examples:\n"
    "  livemvs eval cloud.ply mesh.ply.gz\n"
    "  livemvs eval cloud.ply mesh.ply --box -0.2 -0.1 0 0.2 0.1 0.2 --data recording\n"
    "  livemvs eval cloud.ply scan.ply --tau 1 2 5 --unit cm --json eval.json --plot eval.png\n"
    "  livemvs eval cloud.ply mesh.ply --unit scene --tau 0.01 0.1    (scenes without scale)\n"
    "  livemvs synth --scene hazards --noise 2 --labels-every 5 -o hazards\n"
    "  livemvs run --data hazards --trace hazards.trace -o hazards.ply\n"
    "  livemvs eval hazards.ply hazards/mesh.ply --trace hazards.trace --labels hazards";

struct EvalArguments {
  std::string cloud, reference;
  std::vector<double> box;
  std::string data;
  int view_step = 5;
  std::string unit = "mm";
  double unit_scale = 1;
  std::string json, plot;
  EvaluationOptions options;
  ReportOptions report;
  SeedReportArguments seeds;
};

// What the cloud is judged by; `surface` where it is a mesh.
struct Reference {
  PointCloud cloud;
  std::optional<MeshSurface> surface;
};

double UnitsPerMetre(const std::string& unit) {
  if (unit == "mm") return 1000;
  if (unit == "cm") return 100;
  return 1;
}

std::vector<PosedCamera> ReadCameras(const EvalArguments& args) {
  std::vector<PosedCamera> cameras;
  if (args.data.empty()) return cameras;
  DatasetOptions options;
  options.data = args.data;
  const std::unique_ptr<Dataset> dataset = OpenDataset(options);
  const std::vector<DatasetView>& views = dataset->views();
  for (std::size_t i = 0; i < views.size(); i += static_cast<std::size_t>(args.view_step)) {
    cameras.push_back({views[i].camera, views[i].cam_from_world});
  }
  return cameras;
}

Reference ReadReference(const EvalArguments& args) {
  PlyContents contents = ReadModel(args.reference);
  if (contents.cloud.empty()) throw BadInput(args.reference + ": holds no points");
  Reference reference{std::move(contents.cloud), std::nullopt};
  if (!contents.faces.empty()) {
    contents.cloud = std::move(reference.cloud);
    reference.surface.emplace(MeshOf(contents.cloud, contents.faces, false));
    return reference;
  }
  for (const auto& [option, value] :
       {std::pair{"--data", &args.data}, std::pair{"--trace", &args.seeds.trace}}) {
    if (!value->empty()) {
      throw BadInput(args.reference + ": is a cloud, which hides nothing: " + option +
                     " needs a mesh");
    }
  }
  return reference;
}

Evaluation EvaluateContents(const EvalArguments& args,
                            const PlyContents& judged,
                            const Reference& reference) {
  if (!judged.faces.empty()) {
    const TriangleMesh mesh = MeshOf(judged.cloud, judged.faces, false);
    return reference.surface
               ? EvaluateMesh(mesh, *reference.surface, ReadCameras(args), args.options)
               : EvaluateMesh(mesh, reference.cloud, args.options);
  }
  return reference.surface ? EvaluateAgainstMesh(
                                 judged.cloud, *reference.surface, ReadCameras(args), args.options)
                           : EvaluateAgainstCloud(judged.cloud, reference.cloud, args.options);
}

Evaluation Evaluate(const EvalArguments& args, const Reference& reference) {
  const PlyContents cloud = ReadModel(args.cloud);
  Evaluation result = EvaluateContents(args, cloud, reference);
  result.not_finite += static_cast<std::size_t>(cloud.dropped_vertices);
  if (result.samples_in_box == 0) {
    LogWarning(args.reference + ": none of the reference is in the box; check --box and its unit");
  }
  return result;
}

void WriteJson(const EvalArguments& args,
               const Evaluation& evaluation,
               const std::optional<FalseConvergence>& seeds) {
  auto json = nlohmann::ordered_json::parse(EvaluationJson(evaluation, args.report));
  if (seeds) {
    json["false_convergence"] =
        nlohmann::ordered_json::parse(FalseConvergenceJson(*seeds, args.seeds.Options()));
  }
  AtomicFile file(args.json);
  file.Write(json.dump(2) + "\n");
  file.Commit();
  std::printf("wrote %s\n", args.json.c_str());
}

void RunEval(EvalArguments args) {
  if (!args.box.empty()) {
    args.options.box =
        Box{{args.box[0], args.box[1], args.box[2]}, {args.box[3], args.box[4], args.box[5]}};
  }
  const bool in_scene_units = args.unit == "scene";
  args.report.unit = in_scene_units ? "units" : args.unit;
  args.report.units_per_scene = in_scene_units ? 1 : args.unit_scale * UnitsPerMetre(args.unit);
  args.options.Check();
  args.report.Check();
  args.seeds.Options().Check();
  if (!args.json.empty()) CheckWritable(args.json);
  if (!args.plot.empty()) CheckWritable(args.plot);

  const Reference reference = ReadReference(args);
  const Evaluation evaluation = Evaluate(args, reference);
  std::fputs(EvaluationTable(evaluation, args.report).c_str(), stdout);
  std::optional<FalseConvergence> seeds;
  if (!args.seeds.trace.empty()) {
    seeds = JudgeSeeds(args.seeds, *reference.surface);
    std::printf("\n%s", FalseConvergenceTable(*seeds, args.seeds.Options()).c_str());
  }
  if (!args.json.empty()) WriteJson(args, evaluation, seeds);
  if (!args.plot.empty()) {
    const std::string title = std::filesystem::path(args.cloud).filename().string() + " against " +
                              std::filesystem::path(args.reference).filename().string();
    WritePng(args.plot, EvaluationPlot(evaluation, title, args.report));
    std::printf("wrote %s\n", args.plot.c_str());
  }
}

}  // namespace

void AddEvalCommand(CLI::App& app) {
  auto args = std::make_shared<EvalArguments>();
  CLI::App* command =
      app.add_subcommand("eval", "Measure a cloud against a reference mesh or cloud.");
  command->footer(kEvalExamples);
  command->add_option("CLOUD", args->cloud, "The cloud or mesh to judge (.ply, .ply.gz, .glb)")
      ->required();
  command->add_option("REFERENCE", args->reference, "True mesh or cloud (.ply, .ply.gz, .glb)")
      ->required();
  command
      ->add_option("--box", args->box, "Judge inside of this box only: x0 y0 z0 x1 y1 z1 [scene]")
      ->expected(6);
  command->add_option("--data", args->data, "Data set whose cameras decide which surface was seen");
  command->add_option("--seen", args->options.min_cameras, "Cameras that must see the surface")
      ->capture_default_str();
  command->add_option("--view-step", args->view_step, "Ask every N-th camera of the data set")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--tau", args->report.taus, "Limits of distance, in --unit")
      ->capture_default_str();
  command->add_option("--unit", args->unit, "Unit of --tau and of all results: mm, cm, m, scene")
      ->check(CLI::IsMember({"mm", "cm", "m", "scene"}))
      ->capture_default_str();
  command->add_option("--unit-scale", args->unit_scale, "Metres per scene unit")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--samples", args->options.samples, "Points spread over the reference mesh")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  AddSeedReportOptions(command, &args->seeds);
  command->add_option("--json", args->json, "Write the results to this file");
  command->add_option("--plot", args->plot, "Write a picture of the curves to this file (.png)");
  command->callback([args] { RunEval(*args); });
}

}  // namespace livemvs::app
