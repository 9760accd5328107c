// Absurd points for the map, and absurd meshes for the record that shows them: whatever a PLY file
// or a journal may hold.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "livemvs/map/point_map.h"
#include "viewer/mesh_record.h"

namespace {

using namespace livemvs;

void Require(bool condition) {
  if (!condition) std::abort();
}

template <typename T>
T Take(const std::uint8_t** data, std::size_t* size) {
  T value{};
  const std::size_t bytes = std::min(sizeof(T), *size);
  std::memcpy(&value, *data, bytes);
  *data += bytes;
  *size -= bytes;
  return value;
}

void FuzzMap(const std::uint8_t* data, std::size_t size) {
  PointMapOptions options;
  options.max_bytes = std::size_t{4} << 20;
  PointMap map(options);
  std::vector<MapUpdate> updates;
  std::size_t inserted = 0;
  while (size > 0) {
    std::vector<Point> points(Take<std::uint8_t>(&data, &size) % 8 + 1);
    for (Point& point : points) {
      for (int k = 0; k < 3; ++k) point.position[k] = Take<float>(&data, &size);
      for (int k = 0; k < 3; ++k) point.normal[k] = Take<float>(&data, &size);
      point.sigma = Take<float>(&data, &size);
      point.footprint = Take<float>(&data, &size);
      point.inlier_ratio = Take<float>(&data, &size);
      point.views = Take<std::uint16_t>(&data, &size);
    }
    map.Insert(points, 0, &updates);
    Require(updates.size() == points.size());
    inserted += points.size();
    map.Covers(points[0].position, points[0].footprint, points[0].normal, 0.5F);
  }
  Require(map.size() <= inserted);
  std::size_t visited = 0;
  map.Visit([&](const MapEntry& entry) {
    ++visited;
    Require(entry.point.position.allFinite() && entry.point.normal.allFinite());
    Require(std::isfinite(entry.point.sigma) && entry.point.sigma >= 0);
  });
  Require(visited == map.size());
  for (const float width : {1e-30F, 0.1F, 1e30F})
    Require(map.LevelOfDetail(width).size() <= visited);
}

void FuzzMesh(const std::uint8_t* data, std::size_t size) {
  PlyContents mesh;
  mesh.cloud.resize(Take<std::uint8_t>(&data, &size));
  while (size >= 12) {
    Eigen::Vector3i face;
    for (int k = 0; k < 3; ++k) face[k] = Take<std::int32_t>(&data, &size);
    mesh.faces.push_back(face);
  }
  viewer::EncodeMesh(mesh);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  data[0] % 2 == 0 ? FuzzMap(data + 1, size - 1) : FuzzMesh(data + 1, size - 1);
  return 0;
}
