#pragma once

#include <cstdint>
#include <string>

#include "livemvs/exchange/model.h"

namespace livemvs {

/// A mesh as Draco compressed it, with what glTF's extension has to say about it.
struct DracoMesh {
  std::string bytes;
  std::int64_t points = 0;  ///< After decoding; compression may split or drop vertices.
  std::int64_t faces = 0;
  int position_id = -1, normal_id = -1, color_id = -1;  ///< Attribute ids; -1: absent.
};

/// Compresses a mesh: positions relative to `origin`, normals, and linear 16-bit RGBA colours.
/// @throws Error (kFailed) with Draco's reason.
DracoMesh CompressMesh(const ExchangeModel& model,
                       const Eigen::Vector3d& origin,
                       int position_bits);

}  // namespace livemvs
