#include "livemvs/map/supersede.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "livemvs/map/picked_points.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

// Levels of a pyramid differ by a factor of 2; the distance of the camera varies within one.
constexpr float kFiner = 1 / 1.5F;

// Neighbours that are looked at: where finer points are dense, one of them is among these.
constexpr int kNearby = 8;

}  // namespace

std::vector<char> FindSuperseded(const std::optional<Box>& box, const PointCloud& cloud) {
  const auto inside = [&](const Point& p) {
    return !box || box->Contains(p.position.cast<double>());
  };
  const PickedPoints picked =
      PickPoints(cloud, [](const Point& p) { return p.position.allFinite() && p.footprint > 0; });
  const std::vector<std::size_t>& rows = picked.rows;
  const PointIndex& index = picked.index;
  float finest = std::numeric_limits<float>::infinity();
  for (const std::size_t row : rows) finest = std::min(finest, cloud[row].footprint);
  std::vector<char> superseded(cloud.size(), 0);
  ParallelForRange(0, index.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> neighbors;
    for (std::size_t i = first; i < last; ++i) {
      const Point& coarse = cloud[rows[i]];
      const float footprint = coarse.footprint;
      if (!(footprint * kFiner > finest)) continue;
      index.Nearest(index.points()[i], kNearby, &neighbors);
      for (const PointIndex::Neighbor& n : neighbors) {
        if (n.distance2 > footprint * footprint) break;
        const Point& fine = cloud[rows[n.index]];
        if (!(fine.footprint < kFiner * footprint)) continue;
        if (inside(fine) || !inside(coarse)) superseded[rows[i]] = 1;
      }
    }
  });
  return superseded;
}

}  // namespace livemvs
