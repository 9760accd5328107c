#pragma once

#include <filesystem>
#include <optional>

#include "livemvs/io/dataset_images.h"

namespace livemvs {

/// The file *_par.txt in a folder, if there is exactly one.
/// @throws Error (kBadInput) where there are several.
std::optional<std::filesystem::path> FindMiddlebury(const std::filesystem::path& folder);

/// Reads a *_par.txt of the Middlebury multi-view data sets: a count, then rows `name K(9) R(9)
/// t(3)`, cam_from_world, integer pixel centres. The box is README.txt's "bounding box", if any.
/// @throws Error (kBadInput) naming file, line and remedy; for skew beyond 1/1000 of fx, too.
ImageSet ReadMiddlebury(const std::filesystem::path& par_file);

}  // namespace livemvs
