#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "livemvs/mesh/build_mesh.h"

namespace livemvs::app {

/// What the statistics say of a mesh.
nlohmann::json MeshJson(const BuiltMesh& built);

/// Tells what a user should know of how the mesh came about: points left out, no cameras, coarser
/// voxels or more faces than asked for, defects.
void WarnOfMesh(const MeshStatistics& statistics, const MeshOptions& options);

/// Prints the mesh's size and path.
void PrintMesh(const BuiltMesh& built, const std::filesystem::path& path);

}  // namespace livemvs::app
