#include "livemvs/pipeline/seed_groups.h"

namespace livemvs {

std::vector<SeedGroup> MakeGroups(const std::vector<ReferenceFrame>& references,
                                  const Camera& camera,
                                  const Rigid3d& cam_from_world,
                                  std::size_t levels) {
  std::vector<Camera> cameras;
  std::vector<CameraParams<float>> params;
  for (std::size_t level = 0; level < levels; ++level) {
    cameras.push_back(AtLevel(camera, static_cast<int>(level)));
    params.push_back(MakeCameraParams<float>(cameras.back()));
  }
  std::vector<SeedGroup> groups;
  groups.reserve(references.size());
  for (const ReferenceFrame& reference : references) {
    const auto level = static_cast<std::size_t>(reference.level);
    if (level >= levels) continue;  // a smaller picture than the one they were born in
    groups.push_back({reference.begin,
                      reference.end,
                      reference.level,
                      MakeRelativeView(reference.camera,
                                       reference.cam_from_world,
                                       cameras[level],
                                       params[level],
                                       cam_from_world),
                      static_cast<float>(1 / reference.camera.FocalLength())});
  }
  return groups;
}

}  // namespace livemvs
