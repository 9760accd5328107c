#include "livemvs/eval/evaluate.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "livemvs/map/point_index.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

struct Selection {
  std::vector<Eigen::Vector3f> in_box;
  std::size_t finite = 0;
  std::size_t not_finite = 0;
};

Selection Select(const PointCloud& cloud, const std::optional<Box>& box) {
  Selection selection;
  for (const Point& p : cloud) {
    if (!p.position.allFinite()) {
      ++selection.not_finite;
      continue;
    }
    ++selection.finite;
    if (!box || box->Contains(p.position.cast<double>())) selection.in_box.push_back(p.position);
  }
  return selection;
}

std::vector<float> SortedDistances(const std::vector<Eigen::Vector3f>& from, const PointIndex& to) {
  std::vector<float> distances(from.size());
  ParallelFor(from.size(), [&](std::size_t i) { distances[i] = to.NearestDistance(from[i]); });
  tbb::parallel_sort(distances.begin(), distances.end());
  return distances;
}

/// The judged part of a mesh, and points spread over it.
struct MeshSample {
  std::vector<Eigen::Vector3f> points;
  std::optional<MeshSurface> surface;  ///< Of the triangles that may reach into the box.
  std::size_t not_finite = 0;
};

MeshSample SampleMesh(const TriangleMesh& mesh, const EvaluationOptions& options) {
  TriangleMesh part;
  part.vertices = mesh.vertices;
  MeshSample sample;
  for (Eigen::Vector3f& v : part.vertices) {
    if (v.allFinite()) continue;
    ++sample.not_finite;
    v.setZero();
  }
  const auto corner = [&](const Eigen::Vector3i& face, int k) -> const Eigen::Vector3f& {
    return mesh.vertices[static_cast<std::size_t>(face[k])];
  };
  for (const Eigen::Vector3i& face : mesh.faces) {
    const Eigen::Vector3f &a = corner(face, 0), &b = corner(face, 1), &c = corner(face, 2);
    if (!a.allFinite() || !b.allFinite() || !c.allFinite()) continue;
    if (options.box) {
      const Eigen::Vector3d lo = a.cwiseMin(b).cwiseMin(c).cast<double>();
      const Eigen::Vector3d hi = a.cwiseMax(b).cwiseMax(c).cast<double>();
      if ((hi.array() < options.box->min.array()).any() ||
          (lo.array() > options.box->max.array()).any()) {
        continue;
      }
    }
    part.faces.push_back(face);
  }
  if (part.faces.empty()) return sample;
  sample.surface.emplace(part);
  sample.points = sample.surface->Sample(options.samples, options.seed + 1, options.box);
  return sample;
}

std::vector<float> SortedDistances(const std::vector<Eigen::Vector3f>& from,
                                   const std::optional<MeshSurface>& to) {
  std::vector<float> distances(from.size(), std::numeric_limits<float>::infinity());
  if (to) {
    ParallelFor(from.size(), [&](std::size_t i) {
      distances[i] = static_cast<float>(to->Distance(from[i].cast<double>()));
    });
  }
  tbb::parallel_sort(distances.begin(), distances.end());
  return distances;
}

}  // namespace

Evaluation EvaluateMesh(const TriangleMesh& mesh,
                        const MeshSurface& reference,
                        std::span<const PosedCamera> cameras,
                        const EvaluationOptions& options) {
  options.Check();
  const MeshSample sample = SampleMesh(mesh, options);
  Evaluation result;
  result.points = sample.points.size();
  result.not_finite = sample.not_finite;
  result.cameras = cameras.size();
  result.accuracy.resize(sample.points.size());
  ParallelFor(sample.points.size(), [&](std::size_t i) {
    result.accuracy[i] = static_cast<float>(reference.Distance(sample.points[i].cast<double>()));
  });
  tbb::parallel_sort(result.accuracy.begin(), result.accuracy.end());
  std::vector<Eigen::Vector3f> samples =
      reference.Sample(options.samples, options.seed, options.box);
  result.samples_in_box = samples.size();
  if (!cameras.empty()) samples = SeenSamples(samples, reference, cameras, options);
  result.completeness = SortedDistances(samples, sample.surface);
  return result;
}

Evaluation EvaluateMesh(const TriangleMesh& mesh,
                        const PointCloud& reference,
                        const EvaluationOptions& options) {
  options.Check();
  const MeshSample sample = SampleMesh(mesh, options);
  const Selection samples = Select(reference, options.box);
  Evaluation result;
  result.points = sample.points.size();
  result.not_finite = sample.not_finite;
  result.samples_in_box = samples.in_box.size();
  result.accuracy =
      SortedDistances(sample.points, PointIndex(Select(reference, std::nullopt).in_box));
  result.completeness = SortedDistances(samples.in_box, sample.surface);
  return result;
}

void EvaluationOptions::Check() const {
  if (box && !(box->min.allFinite() && box->max.allFinite() &&
               (box->min.array() < box->max.array()).all())) {
    throw std::invalid_argument("box: the first corner must be less than the second in x, y and z");
  }
  if (samples == 0) throw std::invalid_argument("samples: must be > 0");
  if (min_cameras < 1) {
    throw std::invalid_argument("min_cameras: must be > 0, is " + std::to_string(min_cameras));
  }
  if (!(unblocked > 0 && unblocked <= 1)) {
    throw std::invalid_argument("unblocked: must be in (0, 1]");
  }
}

Evaluation EvaluateAgainstMesh(const PointCloud& cloud,
                               const MeshSurface& reference,
                               std::span<const PosedCamera> cameras,
                               const EvaluationOptions& options) {
  options.Check();
  Selection selection = Select(cloud, options.box);
  Evaluation result;
  result.points = selection.finite;
  result.not_finite = selection.not_finite;
  result.cameras = cameras.size();

  result.accuracy.resize(selection.in_box.size());
  ParallelFor(selection.in_box.size(), [&](std::size_t i) {
    result.accuracy[i] = static_cast<float>(reference.Distance(selection.in_box[i].cast<double>()));
  });
  tbb::parallel_sort(result.accuracy.begin(), result.accuracy.end());

  std::vector<Eigen::Vector3f> samples =
      reference.Sample(options.samples, options.seed, options.box);
  result.samples_in_box = samples.size();
  if (!cameras.empty()) samples = SeenSamples(samples, reference, cameras, options);
  result.completeness = SortedDistances(samples, PointIndex(std::move(selection.in_box)));
  return result;
}

Evaluation EvaluateAgainstCloud(const PointCloud& cloud,
                                const PointCloud& reference,
                                const EvaluationOptions& options) {
  options.Check();
  Selection selection = Select(cloud, options.box);
  const Selection samples = Select(reference, options.box);
  Evaluation result;
  result.points = selection.finite;
  result.not_finite = selection.not_finite;
  result.samples_in_box = samples.in_box.size();
  // A point near the edge of the box may belong to a reference point just outside of it.
  result.accuracy =
      SortedDistances(selection.in_box, PointIndex(Select(reference, std::nullopt).in_box));
  result.completeness = SortedDistances(samples.in_box, PointIndex(std::move(selection.in_box)));
  return result;
}

std::vector<Eigen::Vector3f> SeenSamples(const std::vector<Eigen::Vector3f>& samples,
                                         const MeshSurface& surface,
                                         std::span<const PosedCamera> cameras,
                                         const EvaluationOptions& options) {
  std::vector<Projector> projectors;
  std::vector<Eigen::Vector3f> centers;
  for (const PosedCamera& c : cameras) {
    projectors.emplace_back(c.camera);
    centers.push_back(c.cam_from_world.Center().cast<float>());
  }
  std::vector<char> seen(samples.size(), 0);
  ParallelFor(samples.size(), [&](std::size_t i) {
    int count = 0;
    for (std::size_t c = 0; c < cameras.size() && count < options.min_cameras; ++c) {
      const Eigen::Vector3d in_cam = cameras[c].cam_from_world * samples[i].cast<double>();
      const auto pixel = projectors[c].Project(in_cam);
      if (!pixel || !cameras[c].camera.Contains(*pixel, options.border_px)) continue;
      if (!surface.IsBlocked(
              centers[c], samples[i] - centers[c], static_cast<float>(options.unblocked))) {
        ++count;
      }
    }
    seen[i] = count >= options.min_cameras;
  });
  std::vector<Eigen::Vector3f> result;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (seen[i]) result.push_back(samples[i]);
  }
  return result;
}

double ShareWithin(const std::vector<float>& sorted_distances, double tau) {
  if (sorted_distances.empty()) return 0;
  const auto end = std::lower_bound(sorted_distances.begin(), sorted_distances.end(), tau);
  return static_cast<double>(end - sorted_distances.begin()) /
         static_cast<double>(sorted_distances.size());
}

std::optional<double> Percentile(const std::vector<float>& sorted_distances, double q) {
  if (sorted_distances.empty()) return std::nullopt;
  const double at = q / 100 * static_cast<double>(sorted_distances.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted_distances.size() - 1);
  const double t = at - static_cast<double>(below);
  const double lo = sorted_distances[below], hi = sorted_distances[above];
  return hi > lo ? lo + t * (hi - lo) : lo;  // both may be infinite
}

double FScore(double accuracy, double completeness) {
  const double sum = accuracy + completeness;
  return sum > 0 ? 2 * accuracy * completeness / sum : 0;
}

}  // namespace livemvs
