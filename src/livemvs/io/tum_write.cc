#include <Eigen/Geometry>
#include <cstdio>
#include <string>

#include "livemvs/io/atomic_file.h"
#include "livemvs/io/tum.h"

namespace livemvs {

void WriteTumTrajectory(const std::filesystem::path& file,
                        const std::vector<StampedPose>& poses,
                        const std::string& comment) {
  AtomicFile out(file);
  out.Write("# " + comment + "\n# time tx ty tz qx qy qz qw: the camera in the world\n");
  for (const StampedPose& pose : poses) {
    const Rigid3d world_from_cam = pose.cam_from_world.Inverse();
    const Eigen::Vector3d& t = world_from_cam.translation;
    const Eigen::Quaterniond q(world_from_cam.rotation);
    char row[256];
    std::snprintf(row,
                  sizeof(row),
                  "%.6f %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n",
                  pose.time,
                  t.x(),
                  t.y(),
                  t.z(),
                  q.x(),
                  q.y(),
                  q.z(),
                  q.w());
    out.Write(row);
  }
  out.Commit();
}

}  // namespace livemvs
