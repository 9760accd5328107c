#include "viewer/mesh_record.h"

#include <algorithm>
#include <limits>

#include "livemvs/stream/bytes.h"

namespace livemvs::viewer {
namespace {

constexpr std::size_t kFacesPerPart = 100'000;
constexpr std::uint32_t kHasColors = 1;

}  // namespace

std::vector<std::vector<std::uint8_t>> EncodeMesh(const PlyContents& mesh) {
  std::vector<std::vector<std::uint8_t>> parts;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const auto vertices = static_cast<int>(mesh.cloud.size());
  std::vector<std::uint32_t> number(mesh.cloud.size(), kNone);
  for (std::size_t first = 0; first < mesh.faces.size(); first += kFacesPerPart) {
    const std::size_t end = std::min(first + kFacesPerPart, mesh.faces.size());
    std::vector<int> used;
    std::vector<std::uint32_t> corners;
    for (std::size_t f = first; f < end; ++f) {
      const Eigen::Vector3i& face = mesh.faces[f];
      if (face.minCoeff() < 0 || face.maxCoeff() >= vertices) continue;
      for (const int v : {face.x(), face.y(), face.z()}) {
        if (number[v] == kNone) {
          number[v] = static_cast<std::uint32_t>(used.size());
          used.push_back(v);
        }
        corners.push_back(number[v]);
      }
    }
    std::vector<std::uint8_t> payload;
    ByteWriter out(&payload);
    out.Put(static_cast<std::uint32_t>(used.size()));
    out.Put(static_cast<std::uint32_t>(corners.size() / 3));
    out.Put(mesh.has_colors ? kHasColors : 0U);
    out.Put(0U);
    for (const int v : used) {
      for (int k = 0; k < 3; ++k) out.Put(mesh.cloud[v].position[k]);
    }
    for (const int v : used) {
      for (const std::uint8_t c : mesh.cloud[v].color) out.Put(c);
      out.Put(std::uint8_t{255});
      number[v] = kNone;
    }
    for (const std::uint32_t corner : corners) out.Put(corner);
    parts.push_back(std::move(payload));
  }
  return parts;
}

}  // namespace livemvs::viewer
