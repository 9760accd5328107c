#include "cloud_output.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "livemvs/core/log.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/ply.h"
#include "livemvs/map/finish_cloud.h"
#include "livemvs/map/normals.h"

namespace livemvs::app {

nlohmann::json ReconstructionJson(const Options& options,
                                  const ReconstructionStatistics& s,
                                  std::size_t live_seeds) {
  nlohmann::json json;
  VisitOptions(options, [&](const char* name, const auto&) {
    json["options"][name] = GetOption(options, name);
  });
  json["seeds"] = {{"spawned", s.seeds_spawned},
                   {"converged", s.seeds_converged},
                   {"alive", live_seeds},
                   {"rejected",
                    {{"outlier", s.rejected_outlier},
                     {"aged", s.rejected_aged},
                     {"unseen", s.rejected_unseen},
                     {"left_interval", s.rejected_left_interval},
                     {"one_sided", s.rejected_one_sided}}}};
  json["updates"] = {
      {"total", s.updates.total()},
      {"matched", s.updates.matched},
      {"no_information", s.updates.no_information},
      {"out_of_view", s.updates.out_of_view},
      {"mismatched", s.updates.mismatched},
      {"per_second",
       s.update_seconds > 0 ? static_cast<double>(s.updates.total()) / s.update_seconds : 0}};
  json["seconds"] = {
      {"spawn", s.spawn_seconds}, {"update", s.update_seconds}, {"collect", s.collect_seconds}};
  return json;
}

void AddResources(nlohmann::json* statistics) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  (*statistics)["peak_memory_mb"] = static_cast<double>(usage.ru_maxrss) / 1024;
  (*statistics)["cpu_seconds"] =
      static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
      1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

namespace {

void ExplainEmptyCloud(const ReconstructionStatistics& s, const FinishedCloud& finished) {
  const std::pair<std::size_t, const char*> causes[] = {
      {finished.outside, "they lie outside of the box; check --box and its unit"},
      {finished.overhanging,
       "beside the texture of each no others lie on its surface; film longer, or try --set "
       "overhang_px=0"},
      {finished.unsupported,
       "too few of them lie on a surface with others; try --set min_support=0"},
      {finished.rims,
       "none has others of its surface all around; film longer, or try --set rim_px=0"}};
  const auto& most = *std::max_element(
      std::begin(causes), std::end(causes), [](auto& a, auto& b) { return a.first < b.first; });
  if (most.first > 0) {
    LogWarning(std::string("no point is left: ") + most.second);
    return;
  }
  std::string reason = "too few frames";
  if (s.seeds_spawned == 0) {
    reason = "no pixel has texture within the range: check --box or --near and --far";
  } else if (s.updates.total() == 0 || s.updates.no_information >= s.updates.total() * 9 / 10) {
    reason = "the camera hardly moves, or its pictures are blurred";
  } else if (s.updates.out_of_view > s.updates.total() / 2) {
    reason =
        "what one frame shows, the next do not: check the poses, their convention and the range";
  } else if (s.updates.mismatched > s.updates.matched) {
    reason = "patches are not found where the poses say: check poses, convention and calibration";
  } else if (s.rejected_one_sided > 0) {
    reason = "only parts of the patches match where seeds converge: check poses and calibration";
  }
  LogWarning("no point converged; likely because: " + reason);
}

}  // namespace

FinishedCloud FinishPoints(const Options& options,
                           const SceneRange& range,
                           const ReconstructionStatistics& reconstruction,
                           PointCloud* cloud,
                           nlohmann::json* statistics) {
  FinishedCloud finished = FinishCloud(options, range.box, cloud);
  (*statistics)["points"] = cloud->size();
  (*statistics)["removed"] = {{"overhanging", finished.overhanging},
                              {"superseded", finished.superseded},
                              {"unsupported", finished.unsupported},
                              {"rims", finished.rims},
                              {"outside", finished.outside}};
  if (cloud->empty()) {
    ExplainEmptyCloud(reconstruction, finished);
  } else if (finished.outside > cloud->size()) {
    LogWarning("more points lie just outside of the box (" + std::to_string(finished.outside) +
               ", left out) than in it (" + std::to_string(cloud->size()) +
               "); where it is to cut a table or wall off, --set box_margin=0 does not look there");
  }
  return finished;
}

void WriteCloud(const std::filesystem::path& path, bool estimate_normals, PointCloud* cloud) {
  if (estimate_normals) EstimateNormals(*cloud);
  WritePly(path,
           *cloud,
           estimate_normals ? "of the plane through the 16 nearest points, on the camera's side"
                            : "towards the camera that planted the seed");
}

void SaveStatistics(const std::filesystem::path& path, const nlohmann::json& statistics) {
  AtomicFile file(path);
  // What comes from outside - names, messages - may not be UTF-8.
  file.Write(statistics.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  file.Commit();
}

void WriteStatistics(const std::filesystem::path& path, const nlohmann::json& statistics) {
  SaveStatistics(path, statistics);
  std::printf("%s\n", std::filesystem::absolute(path).c_str());
}

}  // namespace livemvs::app
