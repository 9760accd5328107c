#include "livemvs/eval/view.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace livemvs {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr std::size_t kMaxFitPoints = 200000;

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto nth = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + nth, values.end());
  return values[static_cast<std::size_t>(nth)];
}

/// An even selection of the finite points, small enough for the fit.
std::vector<Eigen::Vector3d> FitPoints(const PointCloud& cloud) {
  const std::size_t step = cloud.size() / kMaxFitPoints + 1;
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (cloud[i].position.allFinite()) points.push_back(cloud[i].position.cast<double>());
  }
  return points;
}

/// Camera axes for a viewer in the given direction: x right, y down, z forward.
Eigen::Matrix3d LookRotation(const Eigen::Vector3d& to_viewer, const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = -to_viewer.normalized();
  Eigen::Vector3d right = forward.cross(up);
  if (right.norm() < 1e-6) right = forward.unitOrthogonal();  // down or up: any heading will do
  right.normalize();
  Eigen::Matrix3d cam_from_world;
  cam_from_world.row(0) = right;
  cam_from_world.row(1) = forward.cross(right);
  cam_from_world.row(2) = forward;
  return cam_from_world;
}

/// Lifts or lowers a direction to the given angle above the horizon, keeping its heading.
Eigen::Vector3d AtElevation(const Eigen::Vector3d& direction,
                            const Eigen::Vector3d& up,
                            double elevation_rad) {
  Eigen::Vector3d heading = direction - direction.dot(up) * up;
  if (heading.norm() < 1e-3) heading = up.unitOrthogonal();
  return std::cos(elevation_rad) * heading.normalized() + std::sin(elevation_rad) * up;
}

Eigen::Vector3d ChooseDirection(const ViewOptions& options,
                                const Eigen::Vector3d& towards_cameras,
                                const Eigen::Vector3d& up) {
  Eigen::Vector3d direction;
  if (options.direction) {
    direction = options.direction->normalized();
  } else {
    // Where the cameras were, but never so flat or so steep that the shape is hard to see.
    Eigen::Vector3d heading = towards_cameras;
    if (heading.norm() < 0.05) heading = AtElevation(Eigen::Vector3d(1, -1, 0.5), up, 0.5);
    const double elevation = std::asin(std::clamp(heading.normalized().dot(up), -1.0, 1.0));
    direction = AtElevation(heading, up, std::clamp(elevation, 18 * kDegree, 50 * kDegree));
  }
  if (options.level) direction = AtElevation(direction, up, 0);
  // Not quite vertical, so that the heading stays the one of the other views.
  if (options.from_above) direction = AtElevation(direction, up, 89.5 * kDegree);
  return Eigen::AngleAxisd(options.turn_deg * kDegree, up) * direction;
}

}  // namespace

void ViewOptions::Check() const {
  constexpr int kMaxSize = 16384;
  if (width < 16 || height < 16 || width > kMaxSize || height > kMaxSize) {
    throw std::invalid_argument("size: must be from 16x16 to 16384x16384");
  }
  if (!(field_of_view_deg > 1 && field_of_view_deg < 150)) {
    throw std::invalid_argument("field_of_view_deg: must be in (1, 150)");
  }
  if (!(margin >= 0 && margin < 0.5)) throw std::invalid_argument("margin: must be in [0, 0.5)");
  for (const auto& v : {direction, up}) {
    if (v && !(v->allFinite() && v->norm() > 0)) {
      throw std::invalid_argument("view, up: must be finite and not zero");
    }
  }
  if (!std::isfinite(turn_deg)) throw std::invalid_argument("turn_deg: must be finite");
}

Eigen::Vector3d MeanViewingDirection(const PointCloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const Point& p : cloud) {
    if (!p.normal.allFinite()) continue;
    sum += p.normal.cast<double>();
    ++count;
  }
  return count > 0 ? Eigen::Vector3d(sum / count) : Eigen::Vector3d::Zero();
}

Eigen::Vector3d GuessUp(const PointCloud& cloud, const Eigen::Vector3d& towards_cameras) {
  // z up is the habit of scenes laid out by hand or by a board, -y up that of a first camera
  // placed at the origin.
  struct Candidate {
    Eigen::Vector3d up;
    double score;
  };
  std::array<Candidate, 4> candidates = {
      {{{0, 0, 1}, 0.3}, {{0, -1, 0}, 0.25}, {{0, 1, 0}, 0.1}, {{0, 0, -1}, 0.0}}};
  const double cos_level = std::cos(20 * kDegree);
  const bool known = towards_cameras.norm() > 0.05;
  for (Candidate& c : candidates) {
    double level = 0;
    for (const Point& p : cloud) level += p.normal.cast<double>().dot(c.up) > cos_level;
    c.score += level / static_cast<double>(std::max<std::size_t>(cloud.size(), 1));
    if (!known) continue;
    const double elevation = std::asin(towards_cameras.normalized().dot(c.up)) / kDegree;
    if (elevation < -10) c.score -= 0.5;  // filmed from below
    if (elevation > 70) c.score -= 0.5;   // straight from above: rather a wall seen head-on
  }
  return std::max_element(candidates.begin(),
                          candidates.end(),
                          [](const Candidate& a, const Candidate& b) { return a.score < b.score; })
      ->up;
}

Eigen::Vector3d UpOfCameras(const std::vector<Rigid3d>& cams_from_world) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rows = Eigen::Matrix3d::Zero();
  for (const Rigid3d& cam : cams_from_world) {
    const Eigen::Vector3d right = cam.rotation.row(0);
    rows += right * right.transpose();
    mean -= cam.rotation.row(1).transpose();
  }
  if (mean.norm() < 1e-9) return Eigen::Vector3d::Zero();
  // The least of u' rows u, with a little weight on staying near the mean.
  constexpr double kMeanWeight = 0.01;
  const Eigen::Vector3d m = mean.normalized();
  rows /= static_cast<double>(cams_from_world.size());
  rows += kMeanWeight * (Eigen::Matrix3d::Identity() - m * m.transpose());
  const Eigen::Vector3d up =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rows).eigenvectors().col(0);
  return up.dot(m) < 0 ? Eigen::Vector3d(-up) : up;
}

RenderView FitView(const PointCloud& cloud,
                   const Eigen::Vector3d& towards_cameras,
                   const ViewOptions& options) {
  options.Check();
  RenderView view;
  view.up = options.up ? options.up->normalized() : GuessUp(cloud, towards_cameras);
  Camera& camera = view.camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = options.height / 2.0 / std::tan(options.field_of_view_deg * kDegree / 2);
  camera.cx = (options.width - 1) / 2.0;
  camera.cy = (options.height - 1) / 2.0;

  const Eigen::Matrix3d rotation =
      LookRotation(ChooseDirection(options, towards_cameras, view.up), view.up);
  std::vector<Eigen::Vector3d> points = FitPoints(cloud);
  if (points.empty()) points.push_back(Eigen::Vector3d::Zero());
  for (Eigen::Vector3d& p : points) p = rotation * p;

  // Start from the middle of the extent, then move and back off until the points fill the picture.
  constexpr double kTail = 0.01;
  std::vector<double> values(points.size());
  Eigen::Vector3d center;
  double extent = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    const double lo = Quantile(values, kTail), hi = Quantile(values, 1 - kTail);
    center[axis] = (lo + hi) / 2;
    extent = std::max(extent, hi - lo);
  }
  if (!(extent > 0)) extent = 1;
  const double reach_x = camera.width / 2.0 * (1 - 2 * options.margin) / camera.fx;
  const double reach_y = camera.height / 2.0 * (1 - 2 * options.margin) / camera.fy;
  double distance = extent;
  for (int iteration = 0; iteration < 4; ++iteration) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d d = points[i] - center;
      values[i] = std::max(std::abs(d.x()) / reach_x, std::abs(d.y()) / reach_y) - d.z();
    }
    distance = std::max(Quantile(values, 1 - kTail), 0.05 * extent);
    for (int axis = 0; axis < 2; ++axis) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double z = std::max(points[i].z() - center.z() + distance, 0.05 * distance);
        values[i] = (points[i][axis] - center[axis]) / z;
      }
      const double middle = (Quantile(values, kTail) + Quantile(values, 1 - kTail)) / 2;
      center[axis] += middle * distance;
    }
  }
  view.cam_from_world.rotation = rotation;
  view.cam_from_world.translation = Eigen::Vector3d(0, 0, distance) - center;
  view.focus_depth = distance;
  return view;
}

}  // namespace livemvs
