#include "livemvs/map/rim.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "livemvs/map/picked_points.h"
#include "livemvs/map/same_surface.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

// A point with others all around leaves no wider gap than this between their directions.
constexpr float kWidestGap = kTurn / 3;

// The others are at least so many, or the point is not judged, ...
constexpr std::size_t kLeastOthers = 8;

// ... found within this many times the radius.
constexpr float kFarthest = 4;

// More neighbours only make gaps narrower: most points are found to be inside with the first few.
constexpr int kNearestOthers[] = {16, 64};

// The widest angle between directions that follow each other around the turn.
float WidestGap(std::vector<float>* directions) {
  if (directions->empty()) return kTurn;
  std::sort(directions->begin(), directions->end());
  float widest = directions->front() + kTurn - directions->back();
  for (std::size_t i = 1; i < directions->size(); ++i) {
    widest = std::max(widest, (*directions)[i] - (*directions)[i - 1]);
  }
  return widest;
}

class Rims {
 public:
  Rims(float radius_px, const PointCloud& cloud)
      : radius_px_(radius_px), cloud_(cloud), points_(PickPoints(cloud, IsWhole)) {}

  std::size_t size() const { return points_.rows.size(); }
  std::size_t Row(std::size_t i) const { return points_.rows[i]; }

  // Buffers, kept between calls to save allocations.
  struct Buffers {
    std::vector<PointIndex::Neighbor> nearest;
    std::vector<float> directions;
  };

  bool IsRim(std::size_t i, Buffers* buffers) const {
    for (const int neighbors : kNearestOthers) {
      points_.index.Nearest(points_.index.points()[i], neighbors, &buffers->nearest);
      FindDirections(i, buffers);
      if (WidestGap(&buffers->directions) <= kWidestGap) return false;
    }
    return buffers->directions.size() >= kLeastOthers;
  }

 private:
  void FindDirections(std::size_t i, Buffers* buffers) const {
    const Point& p = cloud_[points_.rows[i]];
    const Eigen::Vector3f right = p.normal.unitOrthogonal(), up = p.normal.cross(right);
    const float radius = radius_px_ * FinestFootprint(p);
    std::vector<float>& directions = buffers->directions;
    directions.clear();
    for (const PointIndex::Neighbor& n : buffers->nearest) {
      const float reach = directions.size() < kLeastOthers ? kFarthest * radius : radius;
      if (n.distance2 > reach * reach) break;
      const Point& other = cloud_[points_.rows[n.index]];
      const Seen seen = SeenFrom(p, other);
      const float x = seen.across.dot(right), y = seen.across.dot(up);
      if ((x == 0 && y == 0) || !MayShareSurface(p, other, seen)) continue;
      directions.push_back(std::atan2(y, x));
    }
  }

  float radius_px_;
  const PointCloud& cloud_;
  PickedPoints points_;
};

}  // namespace

void RimOptions::Check() const {
  if (!(radius_px > 0 && std::isfinite(radius_px))) {
    throw std::invalid_argument("radius_px must be positive");
  }
}

std::vector<char> FindRims(const RimOptions& options, const PointCloud& cloud) {
  options.Check();
  std::vector<char> marks(cloud.size(), 0);
  const Rims rims(options.radius_px, cloud);
  ParallelForRange(0, rims.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    Rims::Buffers buffers;
    for (std::size_t i = first; i < last; ++i) marks[rims.Row(i)] = rims.IsRim(i, &buffers) ? 1 : 0;
  });
  return marks;
}

}  // namespace livemvs
