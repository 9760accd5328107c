#pragma once

#include <filesystem>
#include <string>

#include "livemvs/io/dataset_images.h"

namespace livemvs {

/// Reads transforms.json as instant-ngp and nerfstudio write it: world_from_cam as 4x4 matrices
/// with OpenGL's axes, intrinsics for all frames or for each, principal point counted from the
/// corner of the image (cx = cx_file - 0.5). Where no extension is given, image files are tried by
/// extension. `applied_transform` and `applied_scale` are noted and otherwise left as they are: the
/// world is the file's own.
/// @throws Error (kBadInput) naming file, place and remedy; also for JSON nested deeper than 64.
ImageSet ReadTransforms(const std::filesystem::path& file);

}  // namespace livemvs
