#include "livemvs/map/overhang.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "livemvs/core/lean.h"
#include "livemvs/map/picked_points.h"
#include "livemvs/map/same_surface.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

// Points that must agree: one may be as wrong as the point itself.
constexpr int kSupporters = 3;

// Places ahead about which they are sought: the first, about which most of those that are there
// lie, at 1 / sqrt(2) of the reach, each other half as far as the one before.
constexpr int kPlaces = 5;

// Of each, the nearest of this many are looked at: a few, which are often enough, then all.
constexpr int kNearPlace[] = {4, 16};

// Most offset sideways of a supporter, in its distance ahead.
constexpr float kSideways = 0.6F;

class Supporters {
 public:
  Supporters(float reach_px, const PointCloud& cloud)
      : reach_px_(reach_px), cloud_(cloud), centred_(PickPoints(cloud, [](const Point& p) {
          return p.lean == kLeanNowhere && IsWhole(p);
        })) {}

  // `nearest`: a buffer, kept between calls to save allocations.
  bool Hold(const Point& p, std::vector<PointIndex::Neighbor>* nearest) const {
    const float reach = reach_px_ * FinestFootprint(p);
    const Eigen::Vector3f ahead = -LeanDirection(p.normal, p.lean);
    std::array<std::uint32_t, kSupporters> found{};
    auto end = found.begin();
    for (const int neighbors : kNearPlace) {
      for (int place = 0; place < kPlaces; ++place) {
        const float distance = std::ldexp(reach / std::numbers::sqrt2_v<float>, -place);
        centred_.index.Nearest(p.position + distance * ahead, neighbors, nearest);
        for (const PointIndex::Neighbor& n : *nearest) {
          if (!Agrees(p, ahead, reach, cloud_[centred_.rows[n.index]])) continue;
          if (std::find(found.begin(), end, n.index) != end) continue;
          *end++ = n.index;
          if (end == found.end()) return true;
        }
      }
    }
    return false;
  }

 private:
  static bool Agrees(const Point& p,
                     const Eigen::Vector3f& ahead,
                     float reach,
                     const Point& other) {
    const Seen seen = SeenFrom(p, other);
    const float far = seen.across.dot(ahead);
    if (!(far > 0 && far <= reach)) return false;
    const float sideways = std::sqrt(std::max(seen.across.squaredNorm() - far * far, 0.0F));
    return sideways <= kSideways * far && MayShareSurface(p, other, seen);
  }

  float reach_px_;
  const PointCloud& cloud_;
  PickedPoints centred_;  // texture all around
};

}  // namespace

void OverhangOptions::Check() const {
  if (!(reach_px > 0 && std::isfinite(reach_px))) {
    throw std::invalid_argument("reach_px must be positive");
  }
}

std::vector<char> FindOverhanging(const OverhangOptions& options, const PointCloud& cloud) {
  options.Check();
  std::vector<char> overhanging(cloud.size(), 0);
  if (std::none_of(cloud.begin(), cloud.end(), [](const Point& p) { return Leans(p.lean); })) {
    return overhanging;  // as with clouds of which nothing is known
  }
  const Supporters supporters(options.reach_px, cloud);
  ParallelForRange(0, cloud.size(), kPointsAtATime, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> nearest;
    for (std::size_t i = first; i < last; ++i) {
      const Point& p = cloud[i];
      if (Leans(p.lean) && IsWhole(p)) overhanging[i] = supporters.Hold(p, &nearest) ? 0 : 1;
    }
  });
  return overhanging;
}

}  // namespace livemvs
