#pragma once

#include <filesystem>

#include "livemvs/core/point.h"
#include "livemvs/io/dataset.h"

namespace livemvs::app {

enum class WorkspaceForm { kColmap, kNerfstudio };

struct WorkspaceSource {
  DatasetOptions dataset;      ///< Pictures, poses, intrinsics.
  std::filesystem::path scan;  ///< Folder of a scan: poses where no dataset is named.
  bool pictures = true;        ///< Bring the pictures along.
  WorkspaceForm form = WorkspaceForm::kColmap;
};

/// Makes a folder from which other programs start: images/, sparse/0 and points in it (COLMAP), or
/// images/, transforms.json and points.ply (nerfstudio). The folder appears whole or not at all.
/// @throws Error (kBadInput) where the folder exists and is not empty, or there are no pictures;
/// Error (kOutOfResource) where something cannot be written.
void WriteWorkspace(const std::filesystem::path& folder,
                    const WorkspaceSource& source,
                    const PointCloud& cloud);

}  // namespace livemvs::app
