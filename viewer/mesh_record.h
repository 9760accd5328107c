#pragma once

#include <cstdint>
#include <vector>

#include "livemvs/io/ply.h"
#include "viewer/stream_log.h"

namespace livemvs::viewer {

/// A part of a mesh; only viewers get it. docs/viewer.md describes its bytes.
inline constexpr auto kRecordMesh = static_cast<RecordType>(259);

/// The payloads of a mesh, each of at most about 100 000 triangles with vertices of its own. Faces
/// that name vertices which are not there are left out.
std::vector<std::vector<std::uint8_t>> EncodeMesh(const PlyContents& mesh);

}  // namespace livemvs::viewer
