#pragma once

#include <cstdint>
#include <map>

#include "livemvs/core/posed_camera.h"

namespace livemvs {

/// Cameras by the index of their frame.
using MeshCameras = std::map<std::int64_t, PosedCamera>;

}  // namespace livemvs
