#include "livemvs/mesh/trim.h"

#include <algorithm>
#include <vector>

#include "livemvs/map/point_index.h"
#include "livemvs/mesh/facing.h"
#include "livemvs/mesh/mesh_topology.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {

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

namespace {

/// Marks the faces that stand on nothing.
void MarkUnsupported(const SightLines& sights,
                     const MeshCameras& cameras,
                     double h,
                     const MeshOptions& options,
                     const TriangleMesh& mesh,
                     std::vector<char>* marks,
                     TrimStatistics* statistics) {
  const std::vector<float> distance = DistancesToPoints(sights, mesh);
  const auto held = static_cast<float>(options.held * h);
  const auto farthest = static_cast<float>(options.support * h);
  std::vector<char> asked(mesh.vertices.size(), 0);
  for (std::size_t v = 0; v < asked.size(); ++v) {
    asked[v] = distance[v] > held && distance[v] <= farthest ? 1 : 0;
  }
  const std::vector<float> facing = FacingOfVertices(mesh, cameras, asked, 2 * h);
  const auto least = static_cast<float>(options.least_facing);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    bool far = false, sideways = false;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.faces[i][k]);
      far = far || distance[v] > farthest;
      sideways = sideways || (asked[v] != 0 && !cameras.empty() && facing[v] < least);
    }
    (*marks)[i] = far || sideways ? 1 : 0;
    statistics->unsupported_faces += far ? 1 : 0;
    statistics->sideways_faces += sideways && !far ? 1 : 0;
  }
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
                        const MeshCameras& cameras,
                        double h,
                        const MeshOptions& options,
                        TriangleMesh* mesh) {
  TrimStatistics statistics;
  if (!options.whole_surface) {
    std::vector<char> marks(mesh->faces.size(), 0);
    MarkUnsupported(sights, cameras, h, options, *mesh, &marks, &statistics);
    RemoveFaces(marks, mesh);
    RemovePinches(mesh);
  }
  statistics.specks = RemoveSpecks(options.least_component, mesh);
  return statistics;
}

}  // namespace livemvs
