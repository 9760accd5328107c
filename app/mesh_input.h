#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "livemvs/core/point.h"
#include "livemvs/io/dataset.h"
#include "livemvs/mesh/sight_lines.h"
#include "livemvs/stream/messages.h"

namespace livemvs::app {

/// A cloud and the cameras that saw it.
struct MeshInput {
  PointCloud cloud;
  MeshCameras cameras;  ///< Empty: unknown.
};

/// Reads a cloud from a PLY file, or from the folder of a scan its cloud.ply and, out of its
/// journal, its cameras.
/// @throws Error (kBadInput) naming the path and what is expected.
MeshInput ReadMeshInput(const std::filesystem::path& path);

/// The cameras of a data set, by frame.
MeshCameras CamerasOf(const std::vector<DatasetView>& views);

/// The camera of a scan where its frames were, by frame; those without a pose are left out.
MeshCameras CamerasOf(const std::optional<Camera>& camera, const std::vector<FrameMessage>& frames);

}  // namespace livemvs::app
