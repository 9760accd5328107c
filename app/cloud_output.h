#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/pipeline/reconstructor.h"

namespace livemvs::app {

/// The reconstruction's part of the statistics: options, seeds, updates, seconds.
/// @param live_seeds  Seeds that are alive at the end.
nlohmann::json ReconstructionJson(const Options& options,
                                  const ReconstructionStatistics& statistics,
                                  std::size_t live_seeds);

/// The process' peak memory and processor time, added to the statistics.
void AddResources(nlohmann::json* statistics);

/// Warns with the likely reason, where no point is left.
void ExplainEmptyCloud(const ReconstructionStatistics& statistics);

/// Writes the cloud, with the normals of planes through neighbours where `estimate_normals`.
void WriteCloud(const std::filesystem::path& path, bool estimate_normals, PointCloud* cloud);

/// Writes statistics as JSON.
void SaveStatistics(const std::filesystem::path& path, const nlohmann::json& statistics);

/// The same, and prints the path.
void WriteStatistics(const std::filesystem::path& path, const nlohmann::json& statistics);

}  // namespace livemvs::app
