#include "scan_results.h"

#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <system_error>

#include "cloud_output.h"
#include "interrupt.h"
#include "livemvs/core/log.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/tum.h"
#include "mesh_input.h"
#include "mesh_output.h"
#include "progress.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

const char* NameOf(ScanEnd end) {
  switch (end) {
    case ScanEnd::kFinished:
      return "finished";
    case ScanEnd::kSourceLost:
      return "camera lost";
    case ScanEnd::kInterrupted:
      return "interrupted";
    case ScanEnd::kFailed:
      break;
  }
  return "failed";
}

nlohmann::json StatisticsOf(const ScanArguments& args,
                            const ScanSettings& settings,
                            const ScanResult& result) {
  const CaptureStatistics& c = result.capture;
  nlohmann::json statistics =
      ReconstructionJson(settings.method, result.reconstruction, result.live_seeds);
  statistics["arguments"] = ToJson(args);
  statistics["preset"] = args.method.preset;
  statistics["range"] = Describe(settings.range);
  statistics["backend"] = result.backend;
  statistics["end"] = NameOf(result.end);
  const std::int64_t seen = c.tracked + c.untracked;
  statistics["frames"] = {{"in_all", result.frames.size()},
                          {"tracked", c.tracked},
                          {"untracked", c.untracked},
                          {"bad_poses", c.bad_poses},
                          {"dropped", c.dropped},
                          {"out_of_order", c.out_of_order},
                          {"duplicated", c.duplicates},
                          {"other_size", c.other_size},
                          {"damaged", c.damaged},
                          {"used", result.reconstruction.frames}};
  statistics["seconds"]["total"] = result.seconds;
  statistics["seconds"]["track"] = c.track_seconds;
  statistics["track_ms_per_frame"] =
      seen > 0 ? 1000 * c.track_seconds / static_cast<double>(seen) : 0.0;
  statistics["frames_per_second"] =
      result.seconds > 0 ? static_cast<double>(seen) / result.seconds : 0.0;
  AddResources(&statistics);
  return statistics;
}

std::vector<StampedPose> PosesOf(const std::vector<FrameMessage>& frames) {
  std::vector<StampedPose> poses;
  for (const FrameMessage& frame : frames) {
    if (!frame.cam_from_world) continue;
    if (!poses.empty() && !(frame.timestamp > poses.back().time)) continue;
    poses.push_back({frame.timestamp, *frame.cam_from_world});
  }
  return poses;
}

void Print(const fs::path& path) { std::printf("%s\n", fs::absolute(path).c_str()); }

BuiltMesh BuildModel(const ScanArguments& args, const ScanResult& result) {
  Progress progress(ParseProgressMode(args.progress));
  // A signal that ended the film does not end the mesh; the next one does.
  const int before = Interruptions();
  CatchInterrupts();
  MeshWatch watch;
  watch.stop = [before] { return Interruptions() > before; };
  watch.progress = [&progress](const std::string& stage, double share) {
    progress.ShowShare("mesh: " + stage, share);
  };
  const MeshOptions options;
  BuiltMesh built =
      BuildMesh(result.points, CamerasOf(result.camera, result.frames), options, watch);
  progress.Finish();
  WarnOfMesh(built.statistics, options);
  return built;
}

/// Writes the mesh. The cloud is safe already: where there is no mesh, a warning says why.
/// @return Whether a signal ended it.
bool WriteModel(const fs::path& folder,
                const ScanArguments& args,
                const ScanResult& result,
                nlohmann::json* statistics) {
  LogInfo("making the mesh; Ctrl-C leaves it out");
  std::fflush(stdout);  // of the cloud is told before the mesh takes its time
  const fs::path path = folder / kModelName;
  std::error_code ignored;
  const std::string older = fs::exists(path, ignored) ? "; " + path.string() + " is of before" : "";
  try {
    const BuiltMesh built = BuildModel(args, result);
    WriteMesh(path, built.mesh);
    (*statistics)["mesh"] = MeshJson(built);
    PrintMesh(built, path);
  } catch (const MeshInterrupted&) {
    LogWarning("interrupted: the mesh was left out; make it with: livemvs mesh " + folder.string() +
               " -o " + path.string() + older);
    (*statistics)["mesh"] = {{"failure", "interrupted"}};
    return true;
  } catch (const std::exception& e) {
    LogWarning("no mesh was made: " + std::string(e.what()) + older);
    (*statistics)["mesh"] = {{"failure", e.what()}};
  }
  return false;
}

}  // namespace

bool WriteScanResults(const fs::path& folder,
                      const ScanArguments& args,
                      const ScanSettings& settings,
                      ScanResult* result) {
  std::exception_ptr failure;
  const auto attempt = [&failure](const std::function<void()>& write) {
    try {
      write();
    } catch (...) {
      if (failure == nullptr) failure = std::current_exception();
    }
  };
  nlohmann::json statistics = StatisticsOf(args, settings, *result);
  attempt([&] {
    FinishPoints(
        settings.method, settings.range, result->reconstruction, &result->points, &statistics);
    WriteCloud(folder / "cloud.ply", true, &result->points);
    std::printf("%zu points from %zu frames\n", result->points.size(), result->frames.size());
    Print(folder / "cloud.ply");
  });
  attempt([&] {
    const std::vector<StampedPose> poses = PosesOf(result->frames);
    if (poses.empty()) return;
    WriteTumTrajectory(folder / "poses.txt", poses, "written by livemvs scan");
    Print(folder / "poses.txt");
  });
  attempt([&] {
    if (!result->camera) return;
    WriteOpenCvYaml(folder / "camera.yaml", *result->camera);
    Print(folder / "camera.yaml");
  });
  bool interrupted = false;
  if (!args.no_mesh && !failure && !result->points.empty()) {
    // Who has no patience for the mesh has all the rest.
    attempt([&] { SaveStatistics(folder / "statistics.json", statistics); });
    interrupted = WriteModel(folder, args, *result, &statistics);
  }
  attempt([&] { WriteStatistics(folder / "statistics.json", statistics); });
  if (failure) std::rethrow_exception(failure);
  return interrupted;
}

}  // namespace livemvs::app
