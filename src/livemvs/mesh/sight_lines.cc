#include "livemvs/mesh/sight_lines.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>

#include "livemvs/core/error.h"
#include "livemvs/map/normals.h"
#include "livemvs/map/point_index.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr std::size_t kLeastPoints = 10;
constexpr int kSpacingNeighbors = 4, kLonelyNeighbors = 8;
constexpr float kLonely = 20;  // times the median distance

float Median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Indices of the finite points, one for each place, in their order.
std::vector<std::uint32_t> DistinctPoints(const PointCloud& cloud, SightLines* result) {
  std::vector<std::uint32_t> order;
  constexpr float kFarthest = 1e15F;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if ((cloud[i].position.array().abs() < kFarthest).all()) {
      order.push_back(static_cast<std::uint32_t>(i));
    }
  }
  result->not_finite = cloud.size() - order.size();
  const auto place = [&](std::uint32_t i) {
    const Eigen::Vector3f& p = cloud[i].position;
    return std::make_tuple(p.x(), p.y(), p.z());
  };
  std::ranges::stable_sort(order, {}, place);
  const std::size_t finite = order.size();
  const auto same = [&](std::uint32_t a, std::uint32_t b) { return place(a) == place(b); };
  order.erase(std::unique(order.begin(), order.end(), same), order.end());
  result->repeated = finite - order.size();
  std::ranges::sort(order);
  return order;
}

/// Distances to the 4th and the 8th neighbour.
struct Distances {
  std::vector<float> spacing, lonely;
};

Distances NeighborDistances(const std::vector<Eigen::Vector3f>& points) {
  Distances distances{std::vector<float>(points.size()), std::vector<float>(points.size())};
  const PointIndex index(points);
  ParallelForRange(0, points.size(), 256, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = first; i < last; ++i) {
      index.Nearest(points[i], kLonelyNeighbors + 1, &neighbors);
      const auto at = [&](std::size_t k) {
        return std::sqrt(neighbors[std::min(k, neighbors.size() - 1)].distance2);
      };
      distances.spacing[i] = at(kSpacingNeighbors);
      distances.lonely[i] = at(kLonelyNeighbors);
    }
  });
  return distances;
}

/// Standard deviation of the points across the line that fits them best, as a share of that along.
double Flatness(const std::vector<SightLine>& lines) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SightLine& l : lines) mean += l.position.cast<double>();
  mean /= static_cast<double>(lines.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const SightLine& l : lines) {
    const Eigen::Vector3d d = l.position.cast<double>() - mean;
    scatter += d * d.transpose();
  }
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  return values[2] > 0 ? std::sqrt(std::max(values[1], 0.0) / values[2]) : 0;
}

Eigen::Vector3f UnitOrZero(const Eigen::Vector3f& v) {
  const float length = v.norm();
  return length > 0 && std::isfinite(length) ? Eigen::Vector3f(v / length)
                                             : Eigen::Vector3f(Eigen::Vector3f::Zero());
}

float Sane(float value, float otherwise) {
  return std::isfinite(value) && value > 0 ? value : otherwise;
}

SightLine LineOf(const Point& point, const MeshCameras& cameras, float short_length, bool* seen) {
  SightLine line;
  line.position = point.position;
  line.normal = UnitOrZero(point.normal);
  line.sigma = Sane(point.sigma, 0);
  line.weight = std::clamp(Sane(point.inlier_ratio, 1), 0.05F, 1.0F);
  const auto camera = point.frame >= 0 ? cameras.find(point.frame) : cameras.end();
  Eigen::Vector3f to_camera = Eigen::Vector3f::Zero();
  if (camera != cameras.end())
    to_camera = camera->second.cam_from_world.Center().cast<float>() - point.position;
  *seen = to_camera.allFinite() && !to_camera.isZero();
  line.direction = *seen ? UnitOrZero(to_camera) : line.normal;
  line.length = *seen ? to_camera.norm() : short_length;
  if (line.normal.dot(line.direction) < 0) line.normal = -line.normal;
  return line;
}

void CheckEnough(const SightLines& result, std::size_t points) {
  const std::size_t left = result.lines.size();
  if (left < kLeastPoints) {
    throw BadInput("a surface needs at least " + std::to_string(kLeastPoints) + " points, " +
                   std::to_string(left) + " of the cloud's " + std::to_string(points) +
                   " are left without those that are not finite (" +
                   std::to_string(result.not_finite) + "), repeated (" +
                   std::to_string(result.repeated) + ") or far from all others (" +
                   std::to_string(result.lonely) + ")");
  }
  constexpr double kLine = 1e-4;
  if (!(result.spacing > 0) || Flatness(result.lines) < kLine) {
    throw BadInput("the points stand in one line, which has no surface");
  }
  if (std::ranges::all_of(result.lines, [](const SightLine& l) { return l.direction.isZero(); })) {
    throw BadInput(
        "the points know neither the frame that saw them nor a normal, so that inside and outside "
        "cannot be told apart; give the data set they come from, or a cloud with normals");
  }
}

}  // namespace

/// Normals of planes through many neighbours, on the side of the lines' cameras: the noise of
/// single points is larger than their spacing.
void FindNormals(std::vector<SightLine>* lines) {
  constexpr int kNeighbors = 48;
  PointCloud points(lines->size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].position = (*lines)[i].position;
    points[i].normal = (*lines)[i].direction;
  }
  EstimateNormals(points, kNeighbors);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(*lines)[i].direction.isZero()) (*lines)[i].normal = points[i].normal;
  }
}

SightLines MakeSightLines(const PointCloud& cloud, const MeshCameras& cameras) {
  SightLines result;
  const std::vector<std::uint32_t> kept = DistinctPoints(cloud, &result);
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(kept.size());
  for (const std::uint32_t i : kept) positions.push_back(cloud[i].position);
  const Distances distances = NeighborDistances(positions);
  const float lonely = kLonely * Median(distances.lonely);
  constexpr float kShortLine = 12;  // times the spacing
  result.spacing = Median(distances.spacing);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    if (distances.lonely[k] > lonely) {
      ++result.lonely;
      continue;
    }
    bool seen = false;
    const Point& point = cloud[kept[k]];
    result.lines.push_back(
        LineOf(point, cameras, kShortLine * static_cast<float>(result.spacing), &seen));
    result.colors.push_back(point.color);
    result.seen += seen ? 1 : 0;
  }
  CheckEnough(result, cloud.size());
  FindNormals(&result.lines);
  return result;
}

}  // namespace livemvs
