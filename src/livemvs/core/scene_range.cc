#include "livemvs/core/scene_range.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

double Percentile(std::vector<double>& values, double fraction) {
  const auto n = static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n), values.end());
  return values[n];
}

double MedianBaseline(const std::vector<PosedCamera>& cameras) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    steps.push_back(
        (cameras[i].cam_from_world.Center() - cameras[i - 1].cam_from_world.Center()).norm());
  }
  return steps.empty() ? 0 : Percentile(steps, 0.5);
}

// The diagonal of the box round the camera centres.
double PathExtent(const std::vector<PosedCamera>& cameras) {
  Eigen::AlignedBox3d box;
  for (const PosedCamera& c : cameras) box.extend(c.cam_from_world.Center());
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

std::optional<SceneRange> RangeOfSparsePoints(const std::vector<PosedCamera>& cameras,
                                              const std::vector<Eigen::Vector3d>& points) {
  constexpr std::size_t kEnough = 20;
  std::vector<double> depths;
  const std::size_t camera_step = cameras.size() / 50 + 1;
  const std::size_t point_step = points.size() / 5000 + 1;
  for (std::size_t i = 0; i < cameras.size(); i += camera_step) {
    const Projector projector(cameras[i].camera);
    for (std::size_t j = 0; j < points.size(); j += point_step) {
      const Eigen::Vector3d p = cameras[i].cam_from_world * points[j];
      const auto pixel = projector.Project(p);
      if (pixel && cameras[i].camera.Contains(*pixel)) depths.push_back(p.z());
    }
  }
  if (depths.size() < kEnough) return std::nullopt;
  SceneRange range;
  // The sparse points are the textured surface; leave room for what lies between and behind them.
  range.near = 0.75 * Percentile(depths, 0.01);
  range.far = 1.35 * Percentile(depths, 0.98);
  range.origin = "the data set's sparse points";
  return range;
}

// The point nearest to all optical axes, or nothing where the axes are close to parallel.
std::optional<Eigen::Vector3d> LookAtPoint(const std::vector<PosedCamera>& cameras) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  for (const PosedCamera& c : cameras) {
    const Eigen::Vector3d axis = c.cam_from_world.rotation.row(2).transpose();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    m += across;
    v += across * c.cam_from_world.Center();
  }
  m /= static_cast<double>(cameras.size());
  v /= static_cast<double>(cameras.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(m);
  constexpr double kParallel = 0.004;  // sin² of the axes' spread: about 4 degrees
  if (eigen.eigenvalues()[0] < kParallel) return std::nullopt;
  return Eigen::Vector3d(m.ldlt().solve(v));
}

std::optional<SceneRange> RangeOfCommonRegion(const std::vector<PosedCamera>& cameras) {
  const auto target = LookAtPoint(cameras);
  if (!target) return std::nullopt;
  std::vector<double> depths;
  for (const PosedCamera& c : cameras) {
    const Eigen::Vector3d p = c.cam_from_world * *target;
    const double sideways = std::hypot(p.x(), p.y());
    if (p.z() > 0 && sideways < 0.5 * p.z()) depths.push_back(p.z());
  }
  // Most cameras must look at it, from farther away than they themselves spread by accident.
  if (depths.size() < cameras.size() * 7 / 10) return std::nullopt;
  SceneRange range;
  range.near = 0.5 * Percentile(depths, 0.05);
  // What stands behind the place is often wanted too, and costs little in inverse depth.
  range.far = 3 * Percentile(depths, 0.95);
  range.origin = "the region that the cameras look at";
  return range;
}

}  // namespace

void SceneRange::Check() const {
  if (box && !((box->min.array() < box->max.array()).all() && box->min.allFinite() &&
               box->max.allFinite())) {
    throw std::invalid_argument(
        "the box is empty or not finite; --box takes x0 y0 z0 x1 y1 z1 with "
        "x0 < x1, y0 < y1, z0 < z1");
  }
  if (!(margin >= 0 && std::isfinite(margin))) {
    throw std::invalid_argument("the box's margin " + std::to_string(margin) +
                                " must be 0 or more");
  }
  if (!(near > 0 && near < far && std::isfinite(far))) {
    throw std::invalid_argument("the depth range " + std::to_string(near) + " ... " +
                                std::to_string(far) +
                                " is empty; --near and --far must be positive "
                                "and near less than far");
  }
}

std::optional<Box> SceneRange::SoughtBox() const {
  if (!box) return std::nullopt;
  return box->Grown(margin);
}

RangeBounds BoundsOf(const SceneRange& range) {
  RangeBounds bounds{};
  bounds.near = range.near;
  bounds.far = range.far;
  const std::optional<Box> box = range.SoughtBox();
  bounds.boxed = box.has_value();
  for (int axis = 0; box && axis < 3; ++axis) {
    bounds.box_min[axis] = box->min[axis];
    bounds.box_max[axis] = box->max[axis];
  }
  return bounds;
}

std::optional<std::pair<double, double>> SceneRange::Along(const Eigen::Vector3d& center,
                                                           const Eigen::Vector3d& direction,
                                                           double cosine) const {
  double lo = 0, hi = 0;
  if (!ClipRay(BoundsOf(*this), center.data(), direction.data(), cosine, &lo, &hi)) {
    return std::nullopt;
  }
  return std::pair(lo, hi);
}

SceneRange RangeOfBox(const Box& box, double margin, const std::vector<PosedCamera>& cameras) {
  SceneRange range;
  range.box = box;
  range.margin = margin * (box.max - box.min).norm();
  const Box sought = *range.SoughtBox();
  std::vector<double> nearest_depths, farthest_depths;
  for (const PosedCamera& c : cameras) {
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p(corner & 1 ? sought.max.x() : sought.min.x(),
                              corner & 2 ? sought.max.y() : sought.min.y(),
                              corner & 4 ? sought.max.z() : sought.min.z());
      const double z = (c.cam_from_world * p).z();
      nearest = std::min(nearest, z);
      farthest = std::max(farthest, z);
    }
    if (!(farthest > 0)) continue;
    nearest_depths.push_back(nearest);
    farthest_depths.push_back(farthest);
  }
  if (farthest_depths.empty()) {
    throw BadInput("no camera looks at the box; check --box and the poses");
  }
  // The box itself ends each ray; depths only have to hold it, whatever a stray camera sees of it.
  range.far = 1.01 * *std::max_element(farthest_depths.begin(), farthest_depths.end());
  range.near = std::max(0.99 * *std::min_element(nearest_depths.begin(), nearest_depths.end()),
                        0.01 * Percentile(farthest_depths, 0.5));
  range.origin = "the box";
  return range;
}

SceneRange DeriveRange(const std::vector<PosedCamera>& cameras,
                       const std::vector<Eigen::Vector3d>& sparse_points) {
  if (const auto range = RangeOfSparsePoints(cameras, sparse_points)) return *range;
  const double extent = PathExtent(cameras);
  if (!(extent > 0)) {
    throw BadInput("the cameras do not move, so depth cannot be seen; check the poses");
  }
  if (const auto range = RangeOfCommonRegion(cameras)) return *range;
  SceneRange range;
  // A walk: what can be measured lies between a few steps and some lengths of the path.
  range.near = std::max(0.15 * extent, 5 * MedianBaseline(cameras));
  range.far = std::max(3 * extent, 4 * range.near);
  range.origin = "the length of the camera's path";
  return range;
}

}  // namespace livemvs
