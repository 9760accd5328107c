#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "livemvs/mesh/build_mesh.h"
#include "output_check.h"

namespace livemvs::app {

/// The files that a mesh of this name is written to: .glb, .ply, or .obj with its material.
/// @throws std::invalid_argument where the name ends in anything else.
std::vector<Output> MeshOutputs(const std::filesystem::path& path);

/// Writes a mesh in the form that the name's ending says.
/// @throws as WriteGlb, WriteObj and WritePly.
void WriteMesh(const std::filesystem::path& path, const TriangleMesh& mesh);

/// What the statistics say of a mesh.
nlohmann::json MeshJson(const BuiltMesh& built);

/// Tells what a user should know of how the mesh came about: points left out, no cameras, coarser
/// voxels or more faces than asked for, defects.
void WarnOfMesh(const MeshStatistics& statistics, const MeshOptions& options);

/// Prints the mesh's size and path.
void PrintMesh(const BuiltMesh& built, const std::filesystem::path& path);

}  // namespace livemvs::app
