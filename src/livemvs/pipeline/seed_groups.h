#pragma once

#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/pose.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

/// How the reference frames of a pool lie to a frame with that camera and pose, whose pyramid has
/// `levels` levels. Those of coarser levels than that are left out.
std::vector<SeedGroup> MakeGroups(const std::vector<ReferenceFrame>& references,
                                  const Camera& camera,
                                  const Rigid3d& cam_from_world,
                                  std::size_t levels);

}  // namespace livemvs
