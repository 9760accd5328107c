#include "livemvs/tracking/frame_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

constexpr char kNotSeen[] = "board not seen";
constexpr int kMinMarkers = 2;
// A pose of a plane has a twin, mirrored about the line of sight. They are told apart where the
// twin fits by this factor worse.
constexpr double kTwinFactor = 1.3;
constexpr double kTwinSame = 0.02;  // twins that differ by less are the same [rad]
constexpr int kCoarseCorners = 24;  // as many are enough to come near

CornerFitOptions CoarseFit(int scale) {
  CornerFitOptions options;
  options.scale = scale;
  options.radius_px = 4;
  options.max_shift_px = 4;
  options.max_asymmetry = 0.25;
  return options;
}

// Corners that stand in one line, or nearly, do not hold a pose.
bool SpreadOut(const std::vector<PointObservation>& observations, const std::vector<bool>& inlier) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  double n = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!inlier[i]) continue;
    mean += observations[i].point.head<2>();
    spread += observations[i].point.head<2>() * observations[i].point.head<2>().transpose();
    ++n;
  }
  if (n < 4) return false;
  spread = spread / n - (mean / n) * (mean / n).transpose();
  const double trace = spread.trace();
  return spread.determinant() > 0.01 * trace * trace;
}

double AngleBetween(const Rigid3d& a, const Rigid3d& b) {
  const double c = 0.5 * ((a.rotation.transpose() * b.rotation).trace() - 1);
  return std::acos(std::clamp(c, -1.0, 1.0));
}

}  // namespace

double MotionBlur(const std::vector<FoundCorner>& corners) {
  if (corners.empty()) return 0;
  std::vector<double> blur;
  blur.reserve(corners.size());
  for (const FoundCorner& c : corners) blur.push_back(c.fit.blur_px);
  const auto middle = blur.begin() + static_cast<std::ptrdiff_t>(blur.size() / 2);
  std::nth_element(blur.begin(), middle, blur.end());
  // A sharp edge is 0.5 px wide already; a motion by b spreads it by b / √12.
  constexpr double kSharp = 0.5;
  return std::sqrt(12 * std::max(0.0, *middle * *middle - kSharp * kSharp));
}

FramePoser::FramePoser(const Board& board, const TrackerOptions& options)
    : options_(options),
      search_(board),
      pattern_(board),
      detector_(board, options.detect_width),
      room_(BoxAbove(board)),
      square_(board.square) {}

// The expected error of the pixel of each corner of the room, from the pose's covariance.
double FramePoser::WorstSigma(const Projector& projector, const PoseFit& fit) const {
  double worst = 0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner((k & 1) != 0 ? room_.max.x() : room_.min.x(),
                                 (k & 2) != 0 ? room_.max.y() : room_.min.y(),
                                 (k & 4) != 0 ? 0.5 * room_.max.z() : room_.min.z());
    const Eigen::Vector3d p = fit.cam_from_world * corner;
    // What the picture does not show does not matter.
    const auto pixel = projector.Project(p);
    if (!pixel || !projector.camera().Contains(*pixel)) continue;
    const auto j = ByMotion(ProjectWithDerivatives(projector.camera(), p, false), p);
    const Eigen::Matrix2d c = j * fit.covariance * j.transpose();
    worst = std::max(worst, std::sqrt(0.5 * c.trace()));
  }
  return worst;
}

std::string FramePoser::Judge(ImageView<std::uint8_t> image,
                              const Projector& projector,
                              FramePose* pose) const {
  const PoseFit& fit = pose->fit;
  if (fit.inliers < options_.min_corners) return "too few corners of the board are seen";
  if (!SpreadOut(pose->observations, fit.inlier)) return "the seen corners are nearly in a line";
  if (fit.rms_px > options_.max_rms_px) {
    return "the corners do not fit the board: is it flat, of this description, and the camera's "
           "calibration right?";
  }
  if ((fit.cam_from_world.rotation.transpose() * -fit.cam_from_world.translation).z() <= 0) {
    return "the board would be seen from below";
  }
  pose->sigma_px = WorstSigma(projector, fit);
  if (pose->sigma_px > options_.max_sigma_px) return "the board is seen too small or too little";
  const MarkerCheck markers = pattern_.Check(image, projector, fit.cam_from_world);
  if (markers.read < kMinMarkers || 4 * markers.read < markers.different) {
    return "the board's markers cannot be read: moved too fast, or another board?";
  }
  pose->blur_px = MotionBlur(pose->corners);
  return {};
}

// Corners at full resolution, the pose from all of them, and the verdict.
FrameResult FramePoser::Refine(ImageView<std::uint8_t> image,
                               const Projector& projector,
                               const Rigid3d& start) const {
  FramePose pose;
  pose.corners = search_.Find(image, search_.ViewsFromPose(projector, start), {});
  pose.observations = search_.Observations(pose.corners);
  const auto fit = FitPose(projector.camera(), pose.observations, start);
  if (!fit) return {std::nullopt, kNotSeen};
  pose.fit = *fit;
  const std::string problem = Judge(image, projector, &pose);
  if (!problem.empty()) return {std::nullopt, problem};
  return {pose, {}};
}

FrameResult FramePoser::Track(ImageView<std::uint8_t> image,
                              const Projector& projector,
                              const Rigid3d& predicted) const {
  const Camera& camera = projector.camera();
  auto start = pattern_.Align(image, camera, predicted, options_.max_motion_px);
  if (!start) return {std::nullopt, kNotSeen};
  // Averaged pixels reach further; once where squares are large, else not at all.
  const double square_px = camera.FocalLength() * square_ / start->translation.z();
  const auto views = search_.ViewsFromPose(projector, *start);
  const int seen = static_cast<int>(
      std::count_if(views.begin(), views.end(), [](const auto& view) { return view.has_value(); }));
  const std::vector<FoundCorner> coarse = search_.Find(
      image, views, CoarseFit(square_px > 24 ? 2 : 1), std::max(1, seen / kCoarseCorners));
  const auto fit = FitPose(camera, search_.Observations(coarse), *start, {.floor_px = 0.3});
  if (!fit) return {std::nullopt, kNotSeen};
  return Refine(image, projector, fit->cam_from_world);
}

FrameResult FramePoser::Detect(ImageView<std::uint8_t> image, const Projector& projector) {
  const std::vector<FoundCorner> corners = DetectCorners(image);
  const std::vector<PointObservation> observations = search_.Observations(corners);
  std::vector<PoseFit> fits;
  for (const Rigid3d& start : PlanarPoses(projector.camera(), observations)) {
    if (const auto fit = FitPose(projector.camera(), observations, start, {.floor_px = 0.1})) {
      fits.push_back(*fit);
    }
  }
  if (fits.empty()) return {std::nullopt, kNotSeen};
  std::sort(fits.begin(), fits.end(), [](const PoseFit& a, const PoseFit& b) {
    return a.inliers != b.inliers ? a.inliers > b.inliers : a.rms_px < b.rms_px;
  });
  if (fits.size() > 1 && AngleBetween(fits[0].cam_from_world, fits[1].cam_from_world) > kTwinSame &&
      fits[1].inliers >= fits[0].inliers && fits[1].rms_px < kTwinFactor * fits[0].rms_px) {
    return {std::nullopt, "the board is seen too straight or too small to tell its tilt"};
  }
  return Refine(image, projector, fits[0].cam_from_world);
}

std::vector<FoundCorner> FramePoser::DetectCorners(ImageView<std::uint8_t> image) {
  const std::vector<DetectedMarker> markers = detector_.Detect(image);
  if (static_cast<int>(markers.size()) < kMinMarkers) return {};
  return search_.FindByMarkers(image, markers, {});
}

}  // namespace livemvs
