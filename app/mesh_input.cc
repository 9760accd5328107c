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
  input.what = path.string();
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    input.cloud = ReadPly(path).cloud;
    return input;
  }
  input.cloud = ReadPly(path / "cloud.ply").cloud;
  const JournalContents journal = ReadJournal(path / kJournalName);
  const Replay& replay = journal.replay;
  for (const FrameMessage& frame : replay.frames()) {
    if (frame.cam_from_world && replay.camera()) {
      input.cameras[frame.index] = {*replay.camera(), *frame.cam_from_world};
    }
  }
  return input;
}

MeshCameras CamerasOf(const std::vector<DatasetView>& views) {
  MeshCameras cameras;
  for (const DatasetView& v : views) cameras[v.index] = {v.camera, v.cam_from_world};
  return cameras;
}

}  // namespace livemvs::app
