#include "livemvs/mesh/trim.h"

#include <algorithm>
#include <vector>

#include "livemvs/map/point_index.h"
#include "livemvs/mesh/mesh_topology.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

/// Distance of each vertex to the nearest point. [scene]
std::vector<float> DistancesToPoints(const SightLines& sights, const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(sights.lines.size());
  for (const SightLine& l : sights.lines) points.push_back(l.position);
  const PointIndex index(std::move(points));
  std::vector<float> distances(mesh.vertices.size());
  ParallelForRange(0, distances.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      distances[i] = index.NearestDistance(mesh.vertices[i]);
    }
  });
  return distances;
}

std::size_t MarkUnsupported(const SightLines& sights,
                            double h,
                            const MeshOptions& options,
                            const TriangleMesh& mesh,
                            std::vector<char>* marks) {
  const std::vector<float> distance = DistancesToPoints(sights, mesh);
  const auto farthest = static_cast<float>(options.support * h);
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    float worst = 0;
    for (int k = 0; k < 3; ++k) {
      worst = std::max(worst, distance[static_cast<std::size_t>(mesh.faces[i][k])]);
    }
    if (worst <= farthest) continue;
    (*marks)[i] = 1;
    ++count;
  }
  return count;
}

std::size_t RemoveSpecks(double least_share, TriangleMesh* mesh) {
  std::size_t count = 0;
  const std::vector<std::int32_t> component = MeshTopology(*mesh).Components(&count);
  std::vector<double> area(count, 0);
  for (std::size_t i = 0; i < mesh->faces.size(); ++i) {
    area[static_cast<std::size_t>(component[i])] += FaceArea(*mesh, i);
  }
  const double largest = area.empty() ? 0 : *std::ranges::max_element(area);
  std::vector<char> marks(mesh->faces.size(), 0);
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (area[static_cast<std::size_t>(component[i])] < least_share * largest) marks[i] = 1;
  }
  RemoveFaces(marks, mesh);
  return static_cast<std::size_t>(
      std::ranges::count_if(area, [&](double a) { return a < least_share * largest; }));
}

void RemovePinches(TriangleMesh* mesh) {
  for (;;) {
    std::vector<char> marks(mesh->faces.size(), 0);
    if (MarkPinches(*mesh, MeshTopology(*mesh), &marks) == 0) return;
    RemoveFaces(marks, mesh);
  }
}

}  // namespace

TrimStatistics TrimMesh(const SightLines& sights,
                        double h,
                        const MeshOptions& options,
                        TriangleMesh* mesh) {
  TrimStatistics statistics;
  if (!options.watertight) {
    std::vector<char> marks(mesh->faces.size(), 0);
    statistics.unsupported_faces = MarkUnsupported(sights, h, options, *mesh, &marks);
    RemoveFaces(marks, mesh);
    RemovePinches(mesh);
  }
  statistics.specks = RemoveSpecks(options.least_component, mesh);
  return statistics;
}

}  // namespace livemvs
