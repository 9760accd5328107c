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
  for (const FrameMessage& frame : journal.replay.frames()) {
    if (frame.cam_from_world) {
      input.cameras[frame.index] = frame.cam_from_world->Center().cast<float>();
    }
  }
  return input;
}

CameraCenters CentersOf(const std::vector<DatasetView>& views) {
  CameraCenters centers;
  for (const DatasetView& v : views) centers[v.index] = v.cam_from_world.Center().cast<float>();
  return centers;
}

}  // namespace livemvs::app
