#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>

#include "commands.h"
#include "dataset_options.h"
#include "export_workspace.h"
#include "livemvs/core/error.h"
#include "livemvs/exchange/glb.h"
#include "livemvs/exchange/las.h"
#include "livemvs/exchange/model.h"
#include "livemvs/exchange/obj.h"
#include "livemvs/io/lower_case.h"
#include "livemvs/io/ply.h"
#include "model_input.h"
#include "output_check.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

constexpr char kExportExamples[] =
    "INPUT is a cloud or mesh (.ply, .ply.gz, .glb), or the folder of a scan. The ending of the\n"
    "output says what to write: .glb .obj .las .ply; --format writes a folder for other programs, "
    "with\n"
    "the pictures of --data and the cloud as points to start from.\n"
    "\n"
    "Examples:\n"
    "  livemvs export cloud.ply -o cloud.glb\n"
    "  livemvs export mesh.ply -o mesh.glb --draco\n"
    "  livemvs export cloud.ply -o cloud.las --min-views 5 --crs utm32.wkt\n"
    "  livemvs export cloud.ply --data recording --format colmap -o workspace\n"
    "  livemvs export mug --data mug.mp4 --format nerfstudio --points 200000 -o splat";

struct ExportArguments {
  std::string input, output, format, crs;
  DatasetOptions dataset;
  bool no_pictures = false;
  std::size_t points = 0;
  int min_views = 0;
  GlbOptions glb;
};

std::string ReadCrs(const std::string& path) {
  if (path.empty()) return {};
  std::ifstream file(path, std::ios::binary);
  constexpr std::size_t kMost = 65536;
  std::string text(kMost, '\0');
  file.read(text.data(), static_cast<std::streamsize>(kMost));
  text.resize(static_cast<std::size_t>(file.gcount()));
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  if (text.empty() || text.find('[') == std::string::npos) {
    throw BadInput(path + ": is no coordinate system in OGC WKT (PROJCS[...], GEOGCS[...])");
  }
  return text;
}

void WritePlyModel(const fs::path& path, const ExchangeModel& model) {
  if (!model.IsMesh()) {
    WritePly(path, model.vertices, "as in the cloud that was exported");
    return;
  }
  WritePly(path, MeshOf(model.vertices, model.faces, model.has_colors));
}

/// Refuses options that the form has no use for, rather than pass over them.
void CheckArguments(const ExportArguments& args, const std::string& extension) {
  const bool folder = !args.format.empty();
  const auto refuse = [](const char* option, const char* why) {
    throw std::invalid_argument(std::string(option) + ": " + why);
  };
  if (!folder && extension != ".glb" && extension != ".obj" && extension != ".las" &&
      extension != ".ply") {
    refuse("--output",
           "the name must end with .glb, .obj, .las or .ply, or --format colmap or nerfstudio be "
           "given");
  }
  if (args.glb.draco && (folder || extension != ".glb")) refuse("--draco", "is for .glb");
  if (!args.crs.empty() && (folder || extension != ".las")) refuse("--crs", "is for .las");
  if (!folder && !args.dataset.data.empty()) refuse("--data", "is for --format");
  if (!folder && args.no_pictures) refuse("--no-pictures", "is for --format");
}

void WriteFile(const ExportArguments& args,
               const std::string& extension,
               const ExchangeModel& model) {
  if (extension == ".glb") {
    WriteGlb(args.output, model, args.glb);
  } else if (extension == ".obj") {
    WriteObj(args.output, model);
  } else if (extension == ".las") {
    WriteLas(args.output, model, {.crs_wkt = ReadCrs(args.crs)});
  } else {
    WritePlyModel(args.output, model);
  }
}

void RunExport(ExportArguments args) {
  const std::string extension = LowerExtension(args.output);
  CheckArguments(args, extension);
  const bool is_scan = fs::is_directory(args.input);
  const fs::path file = is_scan ? fs::path(args.input) / "cloud.ply" : fs::path(args.input);
  if (args.format.empty()) CheckOutputs({{args.output, "the output", "", ""}}, {file});
  ExchangeModel model = MakeExchangeModel(ReadModel(file), file.string());
  ThinCloud(args.points, args.min_views, &model);
  if (model.vertices.empty()) {
    throw BadInput(file.string() + ": no point has " + std::to_string(args.min_views) +
                   " views (--min-views)");
  }
  if (args.format.empty()) {
    WriteFile(args, extension, model);
  } else {
    WorkspaceSource source{.dataset = args.dataset, .pictures = !args.no_pictures};
    if (args.format == "nerfstudio") source.form = WorkspaceForm::kNerfstudio;
    if (is_scan) {
      source.scan = args.input;
      if (source.dataset.poses.empty()) source.dataset.poses = source.scan / "poses.txt";
      if (source.dataset.camera.empty()) {
        source.dataset.camera = (source.scan / "camera.yaml").string();
      }
    }
    WriteWorkspace(args.output, source, model.vertices);
  }
  std::printf("%s\n", fs::absolute(args.output).c_str());
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  static const std::map<std::string, UpAxis> kAxes = {
      {"z", UpAxis::kZ}, {"y", UpAxis::kY}, {"-y", UpAxis::kMinusY}};
  auto args = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Write what other programs open.");
  command->footer(kExportExamples);
  command->add_option("INPUT", args->input, "Cloud, mesh, or folder of a scan")->required();
  command->add_option("-o,--output", args->output, "File, or folder with --format")->required();
  command->add_option("--format", args->format, "colmap or nerfstudio: a folder")
      ->check(CLI::IsMember({"colmap", "nerfstudio"}));
  AddDatasetOptions(command, &args->dataset)->required(false);
  command->add_flag("--no-pictures", args->no_pictures, "Leave the pictures out");
  command->add_option("--points", args->points, "At most so many points of a cloud; 0: all");
  command->add_option("--min-views", args->min_views, "Points that so many frames agreed on");
  command->add_option("--up", args->glb.up, "GLB: what points up in the world: z, y or -y")
      ->transform(CLI::CheckedTransformer(kAxes));
  command->add_flag("--draco", args->glb.draco, "GLB: compress the mesh");
  command->add_option("--crs", args->crs, "LAS: file with the coordinate system in OGC WKT");
  command->callback([args] { RunExport(*args); });
}

}  // namespace livemvs::app
