#include "mesh_input.h"

#include "livemvs/core/error.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/ply.h"
#include "livemvs/stream/replay.h"
#include "scan_results.h"

namespace livemvs::app {

namespace fs = std::filesystem;

MeshInput ReadMeshInput(const fs::path& path) {
  MeshInput input;
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    input.cloud = ReadPly(path).cloud;
    return input;
  }
  input.cloud = ReadPly(path / "cloud.ply").cloud;
  const JournalContents journal = ReadJournal(path / kJournalName);
  input.cameras = CamerasOf(journal.replay.camera(), journal.replay.frames());
  return input;
}

MeshCameras CamerasOf(const std::optional<Camera>& camera,
                      const std::vector<FrameMessage>& frames) {
  MeshCameras cameras;
  if (!camera) return cameras;
  for (const FrameMessage& frame : frames) {
    if (frame.cam_from_world) cameras[frame.index] = {*camera, *frame.cam_from_world};
  }
  return cameras;
}

MeshCameras CamerasOf(const std::vector<DatasetView>& views) {
  MeshCameras cameras;
  for (const DatasetView& v : views) cameras[v.index] = {v.camera, v.cam_from_world};
  return cameras;
}

}  // namespace livemvs::app
