#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/core/scene_range.h"
#include "livemvs/map/finish_cloud.h"
#include "livemvs/pipeline/reconstructor.h"

namespace livemvs::app {

/// The reconstruction's part of the statistics: options, seeds, updates, seconds.
/// @param live_seeds  Seeds that are alive at the end.
nlohmann::json ReconstructionJson(const Options& options,
                                  const ReconstructionStatistics& statistics,
                                  std::size_t live_seeds);

/// The process' peak memory and processor time, added to the statistics.
void AddResources(nlohmann::json* statistics);

/// Finishes the cloud, and adds its points, and those that were taken out, to the statistics. Warns
/// where no point is left, with the likely reason, or most lie outside of the box.
FinishedCloud FinishPoints(const Options& options,
                           const SceneRange& range,
                           const ReconstructionStatistics& reconstruction,
                           PointCloud* cloud,
                           nlohmann::json* statistics);

/// Writes the cloud, with the normals of planes through neighbours where `estimate_normals`.
void WriteCloud(const std::filesystem::path& path, bool estimate_normals, PointCloud* cloud);

/// Writes statistics as JSON.
void SaveStatistics(const std::filesystem::path& path, const nlohmann::json& statistics);

/// The same, and prints the path.
void WriteStatistics(const std::filesystem::path& path, const nlohmann::json& statistics);

}  // namespace livemvs::app
