#pragma once

#include <filesystem>

#include "livemvs/io/ply.h"

namespace livemvs::app {

/// Whether the name is that of a cloud or mesh: .glb, .ply or .ply.gz.
bool IsModelName(const std::filesystem::path& path);

/// Reads a cloud or mesh: a GLB file that livemvs wrote, otherwise PLY.
/// @throws Error (kBadInput) naming the file and what is wrong with it.
PlyContents ReadModel(const std::filesystem::path& path);

}  // namespace livemvs::app
