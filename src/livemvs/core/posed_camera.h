#pragma once

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// A camera at a place.
struct PosedCamera {
  Camera camera;
  Rigid3d cam_from_world;
};

}  // namespace livemvs
