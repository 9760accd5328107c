// Hostile bytes as a PLY file, plain or compressed, and what is read as the viewer shows it.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "file_input.h"
#include "livemvs/core/error.h"
#include "livemvs/io/ply.h"
#include "livemvs/stream/point_codec.h"
#include "viewer/mesh_record.h"

namespace {

using namespace livemvs;

void Require(bool condition) {
  if (!condition) std::abort();
}

void Show(const PlyContents& ply) {
  if (!ply.faces.empty()) {
    viewer::EncodeMesh(ply);
    return;
  }
  std::size_t shown = 0;
  for (const PointCloud& group : GroupForStream(ply.cloud)) {
    const auto decoded = DecodePoints(EncodePoints(0, static_cast<std::uint32_t>(shown), group));
    Require(decoded && decoded->points.size() == group.size());
    shown += group.size();
  }
  Require(shown <= ply.cloud.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const FileInput file(std::span<const std::uint8_t>(data, size));
    Show(ReadPly(file.path()));
  } catch (const Error&) {
    return 0;
  }
  return 0;
}
