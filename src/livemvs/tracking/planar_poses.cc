// The poses of a plane from the directions to its points: OpenCV's infinitesimal plane-based pose
// estimation.

#include <opencv2/calib3d.hpp>

#include "livemvs/tracking/pose_fit.h"

namespace livemvs {

std::vector<Rigid3d> PlanarPoses(const Camera& camera,
                                 const std::vector<PointObservation>& observations) {
  const Projector projector(camera);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> rays;
  for (const PointObservation& o : observations) {
    const auto ray = projector.Unproject(o.pixel);
    if (!ray) continue;
    points.emplace_back(o.point.x(), o.point.y(), 0);
    rays.emplace_back(ray->x(), ray->y());
  }
  std::vector<Rigid3d> poses;
  if (points.size() < 4) return poses;
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solvePnPGeneric(points,
                        rays,
                        cv::Matx33d::eye(),
                        cv::noArray(),
                        rotations,
                        translations,
                        false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return poses;  // points on a line and the like
  }
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    cv::Matx33d r;
    cv::Rodrigues(rotations[i], r);
    Rigid3d pose;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) pose.rotation(a, b) = r(a, b);
      pose.translation[a] = translations[i].at<double>(a);
    }
    if (pose.rotation.allFinite() && pose.translation.allFinite()) poses.push_back(pose);
  }
  return poses;
}

}  // namespace livemvs
