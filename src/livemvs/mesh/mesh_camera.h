#pragma once

#include <cstdint>
#include <map>

#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// A camera that saw the points.
struct MeshCamera {
  Camera camera;
  Rigid3d cam_from_world;

  Eigen::Vector3f Center() const { return cam_from_world.Center().cast<float>(); }
};

/// Cameras by the index of their frame.
using MeshCameras = std::map<std::int64_t, MeshCamera>;

}  // namespace livemvs
