#include "livemvs/tracking/rolling_shutter.h"

#include <Eigen/Dense>
#include <cmath>

#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

constexpr double kMinReadout = 0.1;  // less of it does no harm
constexpr double kCertainty = 8;     // standard deviations; errors of corners are not independent
constexpr double kMinMotion = 1;     // rms from frame to frame that tells anything [px]
constexpr double kMaxMotion = 100;   // more is no motion but a gap [px]

}  // namespace

void RollingShutterWatch::Add(const Camera& camera,
                              const PoseFit& pose,
                              const std::vector<PointObservation>& observations,
                              const Rigid3d& previous) {
  const int n = 2 * pose.inliers;
  Eigen::MatrixXd by_pose(n, 6);
  Eigen::VectorXd effect(n), residual(n);
  double motion = 0;
  int row = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!pose.inlier[i]) continue;
    const Eigen::Vector3d p = pose.cam_from_world * observations[i].point;
    const Eigen::Vector3d before = previous * observations[i].point;
    if (before.z() <= 0) return;
    const PointProjection at = ProjectWithDerivatives(camera, p, false);
    const Eigen::Vector2d v = at.pixel - ProjectWithDerivatives(camera, before, false).pixel;
    motion += v.squaredNorm() / pose.inliers;
    by_pose.middleRows<2>(row) = ByMotion(at, p);
    effect.segment<2>(row) = (at.pixel.y() / camera.height - 0.5) * v;
    residual.segment<2>(row) = observations[i].pixel - at.pixel;
    row += 2;
  }
  if (motion < kMinMotion * kMinMotion || motion > kMaxMotion * kMaxMotion) return;
  // What no change of the pose can explain.
  const auto qr = by_pose.householderQr();
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(n, 6);
  effect -= q * (q.transpose() * effect);
  residual -= q * (q.transpose() * residual);
  weighted_ += effect.dot(residual);
  weights_ += effect.squaredNorm();
  squares_ += residual.squaredNorm();
  count_ += n - 6;
}

std::optional<double> RollingShutterWatch::Readout() const {
  if (weights_ <= 0 || count_ <= 0) return std::nullopt;
  const double readout = weighted_ / weights_;
  const double sigma = std::sqrt(squares_ / static_cast<double>(count_) / weights_);
  if (readout < kMinReadout || readout < kCertainty * sigma) return std::nullopt;
  return readout;
}

}  // namespace livemvs
