#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/eval/depth_check.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/picture_codec.h"
#include "livemvs/io/ply.h"

namespace livemvs::app {
namespace {

constexpr char kDepthCheckExamples[] =
    "FOLDER holds depth pictures (16-bit PNG, millimetres, 0 or 65535: none) and cams_depth.txt,\n"
    "per line: picture w h fx fy cx cy k1 k2 p1 p2 R(9) t(3), camera from world, metres.\n"
    "A point within 0.1 m of the depth seen at its pixel agrees; one that is more in front of it\n"
    "floats; one that is more behind it may be hidden and is not judged.\n"
    "\n"
    "Examples:\n"
    "  livemvs depth-check cloud.ply recording\n"
    "  livemvs depth-check cloud.ply recording --max 5 --json depth.json";

struct DepthCheckArguments {
  std::string cloud, folder, json;
  DepthCheckOptions options;
};

std::string ToJson(const DepthCheckResult& result, const DepthCheckOptions& options) {
  nlohmann::ordered_json json;
  json["points"] = result.points;
  json["frames"] = result.frames;
  json["comparisons_agree"] = result.agree;
  json["comparisons_floating"] = result.floating;
  json["comparisons_behind"] = result.behind;
  json["median_z_error"] = nullptr;
  if (!result.errors.empty()) json["median_z_error"] = result.MedianError();
  json["floating_share"] = result.FloatingShare();
  json["z_min"] = options.z_min;
  json["z_max"] = options.z_max;
  json["tolerance"] = options.tolerance;
  return json.dump(2) + "\n";
}

void RunDepthCheck(const DepthCheckArguments& args) {
  args.options.Check();
  if (!args.json.empty()) CheckWritable(args.json);
  const std::filesystem::path folder(args.folder);
  const std::vector<DepthView> views = ReadDepthViews(folder / "cams_depth.txt");
  const PointCloud cloud = ReadPly(args.cloud).cloud;
  DepthCheckResult result;
  int missing = 0;
  for (const DepthView& view : views) {
    const std::filesystem::path path = folder / view.name;
    if (!std::filesystem::exists(path)) {
      ++missing;
      continue;
    }
    const Image<std::uint16_t> depth = ReadDepthPng(path);
    if (depth.width() != view.camera.width || depth.height() != view.camera.height) {
      throw BadInput(path.string() + ": its size is not the one that cams_depth.txt states");
    }
    CompareWithDepth(cloud, view, depth, args.options, &result);
  }
  if (missing > 0) {
    LogWarning(args.folder + ": " + std::to_string(missing) + " of " +
               std::to_string(views.size()) + " depth pictures do not exist");
  }
  if (result.frames == 0) throw BadInput(args.folder + ": no depth picture can be read");
  std::printf("points %lld, depth pictures %lld, comparisons %lld\n",
              static_cast<long long>(result.points),
              static_cast<long long>(result.frames),
              static_cast<long long>(result.agree + result.floating));
  if (result.agree + result.floating == 0) {
    std::printf("no point can be compared: none lies before a measured depth\n");
  } else {
    std::printf("median |z error| of points that agree   %.4f m\n", result.MedianError());
    std::printf("floats in front of the seen surface     %.2f%%\n", 100 * result.FloatingShare());
  }
  if (!args.json.empty()) {
    AtomicFile file(args.json);
    file.Write(ToJson(result, args.options));
    file.Commit();
    std::printf("wrote %s\n", args.json.c_str());
  }
}

}  // namespace

void AddDepthCheckCommand(CLI::App& app) {
  auto args = std::make_shared<DepthCheckArguments>();
  CLI::App* command =
      app.add_subcommand("depth-check", "Compare a cloud with the pictures of a depth camera.");
  command->footer(kDepthCheckExamples);
  command->add_option("CLOUD", args->cloud, "The cloud to judge (.ply, .ply.gz)")->required();
  command->add_option("FOLDER", args->folder, "Depth pictures and cams_depth.txt")->required();
  command->add_option("--min", args->options.z_min, "Judge points farther than this only [m]")
      ->capture_default_str();
  command->add_option("--max", args->options.z_max, "Judge points nearer than this only [m]")
      ->capture_default_str();
  command->add_option("--tolerance", args->options.tolerance, "Points this far in front float [m]")
      ->capture_default_str();
  command->add_option("--json", args->json, "Write the results to this file");
  command->callback([args] { RunDepthCheck(*args); });
}

}  // namespace livemvs::app
