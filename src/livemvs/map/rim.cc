#include "livemvs/map/rim.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
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

// ... found within this many times the radius, among this many points: in a few, mostly.
constexpr float kFarthest = 4;
constexpr int kAmong[] = {16, 64};

// The twelfths of a turn in which there are others.
class Twelfths {
 public:
  void Add(const Eigen::Vector2f& direction) {
    constexpr float kTan30 = 0.57735027F, kTan60 = 1.7320508F;
    const float x = std::abs(direction.x()), y = std::abs(direction.y());
    const int from_x = static_cast<int>(y > kTan30 * x) + static_cast<int>(y > kTan60 * x);
    const int half = direction.x() < 0 ? 5 - from_x : from_x;
    taken_ |= 1U << (direction.y() < 0 ? 11 - half : half);
  }

  // Whether no three in a row are free, as they are in any gap of more than a third of a turn.
  bool LeaveNoGap() const {
    const std::uint32_t free = ~taken_ & 0xFFFU, twice = free | free << 12;
    return (twice & twice >> 1 & twice >> 2) == 0;
  }

 private:
  std::uint32_t taken_ = 0;
};

// Buffers, kept between calls to save allocations.
struct Buffers {
  std::vector<PointIndex::Neighbor> nearest;
  std::vector<Eigen::Vector2f> directions;
  std::vector<float> angles;
};

// The widest angle between directions that follow each other around the turn.
float WidestGap(Buffers* buffers) {
  std::vector<float>& angles = buffers->angles;
  angles.clear();
  for (const Eigen::Vector2f& d : buffers->directions) angles.push_back(std::atan2(d.y(), d.x()));
  std::sort(angles.begin(), angles.end());
  float widest = angles.front() + kTurn - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) {
    widest = std::max(widest, angles[i] - angles[i - 1]);
  }
  return widest;
}

// Where others lie around a point, as its camera saw it.
class Surroundings {
 public:
  explicit Surroundings(const Point& p)
      : p_(p), right_(p.normal.unitOrthogonal()), up_(p.normal.cross(right_)) {}

  // Nothing where the other may be of another surface or lies in no direction.
  std::optional<Eigen::Vector2f> DirectionOf(const Point& other) const {
    const Seen seen = SeenFrom(p_, other);
    const Eigen::Vector2f direction(seen.across.dot(right_), seen.across.dot(up_));
    if (direction.isZero(0) || !MayShareSurface(p_, other, seen)) return std::nullopt;
    return direction;
  }

 private:
  const Point& p_;
  Eigen::Vector3f right_, up_;
};

class Rims {
 public:
  Rims(float radius_px, const PointCloud& cloud)
      : radius_px_(radius_px), cloud_(cloud), points_(PickPoints(cloud, IsWhole)) {}

  std::size_t size() const { return points_.rows.size(); }
  std::size_t Row(std::size_t i) const { return points_.rows[i]; }

  bool IsRim(std::size_t i, Buffers* buffers) const {
    const Point& p = cloud_[points_.rows[i]];
    const Surroundings around(p);
    const float radius = radius_px_ * FinestFootprint(p);
    std::vector<Eigen::Vector2f>& directions = buffers->directions;
    directions.clear();
    Twelfths twelfths;
    points_.index.VisitNear(p.position, radius, [&](const PointIndex::Neighbor& n) {
      if (const auto direction = around.DirectionOf(Other(n))) {
        directions.push_back(*direction);
        twelfths.Add(*direction);
      }
      return !twelfths.LeaveNoGap();
    });
    if (twelfths.LeaveNoGap()) return false;
    if (directions.size() < kLeastOthers) FindNearest(p, around, kFarthest * radius, buffers);
    return directions.size() >= kLeastOthers && WidestGap(buffers) > kWidestGap;
  }

 private:
  const Point& Other(const PointIndex::Neighbor& n) const { return cloud_[points_.rows[n.index]]; }

  // Directions of the nearest others, as many as there must be.
  void FindNearest(const Point& p,
                   const Surroundings& around,
                   float radius,
                   Buffers* buffers) const {
    for (const int among : kAmong) {
      points_.index.Nearest(p.position, among, &buffers->nearest);
      buffers->directions.clear();
      for (const PointIndex::Neighbor& n : buffers->nearest) {
        if (n.distance2 > radius * radius) return;
        const auto direction = around.DirectionOf(Other(n));
        if (direction) buffers->directions.push_back(*direction);
        if (buffers->directions.size() == kLeastOthers) return;
      }
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
    Buffers buffers;
    for (std::size_t i = first; i < last; ++i) marks[rims.Row(i)] = rims.IsRim(i, &buffers) ? 1 : 0;
  });
  return marks;
}

}  // namespace livemvs
