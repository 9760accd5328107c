#include "livemvs/map/normals.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>

#include "livemvs/map/point_index.h"

namespace livemvs {
namespace {

Point At(const Eigen::Vector3f& position, const Eigen::Vector3f& towards_camera) {
  Point p;
  p.position = position;
  p.normal = towards_camera;
  return p;
}

double AngleDeg(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const double s = a.cast<double>().cross(b.cast<double>()).norm();
  return std::atan2(s, a.cast<double>().dot(b.cast<double>())) * 180 / M_PI;
}

/// A plane of points with the given normal, seen from above it, with noise along the normal.
PointCloud Plane(const Eigen::Vector3f& normal, int count, float noise, const Eigen::Vector3f& at) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::normal_distribution<float> gauss(0, 1);
  const Eigen::Vector3f a = normal.unitOrthogonal();
  const Eigen::Vector3f b = normal.cross(a);
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f p =
        at + uniform(rng) * a + uniform(rng) * b + noise * gauss(rng) * normal;
    const Eigen::Vector3f view = (normal + 0.5f * a * uniform(rng)).normalized();
    cloud.push_back(At(p, view));
  }
  return cloud;
}

TEST(EstimateNormals, PlaneGivesItsNormalOnTheCamerasSide) {
  const Eigen::Vector3f n = Eigen::Vector3f(1, -2, 3).normalized();
  for (const Eigen::Vector3f& side : {n, Eigen::Vector3f(-n)}) {
    PointCloud cloud = Plane(side, 2000, 0, {10, 20, 30});
    EstimateNormals(cloud);
    for (const Point& p : cloud) {
      ASSERT_LT(AngleDeg(p.normal, side), 0.1);
      ASSERT_NEAR(p.normal.norm(), 1, 1e-5);
    }
  }
}

TEST(EstimateNormals, NoisyPlaneStaysWithinAFewDegrees) {
  const Eigen::Vector3f n(0, 0, 1);
  // Spacing is 2 / sqrt(4000) = 0.03; noise of a tenth of it tilts 16 neighbours by about 3 deg.
  PointCloud cloud = Plane(n, 4000, 0.003f, Eigen::Vector3f::Zero());
  EstimateNormals(cloud);
  double sum = 0;
  for (const Point& p : cloud) sum += AngleDeg(p.normal, n);
  EXPECT_LT(sum / 4000, 5);
  EXPECT_GT(sum / 4000, 0.5);  // noise there is
}

TEST(EstimateNormals, SphereNormalsAreRadial) {
  std::mt19937 rng(3);
  std::normal_distribution<float> gauss(0, 1);
  PointCloud cloud;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3f r = Eigen::Vector3f(gauss(rng), gauss(rng), gauss(rng)).normalized();
    cloud.push_back(At(0.5f * r, (r + Eigen::Vector3f(0.3f, 0, 0)).normalized()));
  }
  EstimateNormals(cloud);
  for (const Point& p : cloud) ASSERT_LT(AngleDeg(p.normal, p.position.normalized()), 6);
}

TEST(EstimateNormals, WithoutAPlaneTheViewingDirectionStays) {
  const Eigen::Vector3f view = Eigen::Vector3f(1, 1, 1).normalized();
  PointCloud few = {At({0, 0, 0}, view), At({1, 0, 0}, view)};
  PointCloud same(40, At({1, 2, 3}, view));
  PointCloud line;
  for (int i = 0; i < 100; ++i) line.push_back(At({0.1f * static_cast<float>(i), 0, 0}, view));
  for (PointCloud* cloud : {&few, &same, &line}) {
    EstimateNormals(*cloud);
    for (const Point& p : *cloud) ASSERT_EQ(p.normal, view);
  }
  PointCloud empty;
  EstimateNormals(empty);
  EXPECT_TRUE(empty.empty());
}

TEST(EstimateNormals, LonelyAndBrokenPointsStayAsTheyAre) {
  PointCloud cloud = Plane({0, 0, 1}, 1000, 0, Eigen::Vector3f::Zero());
  const Eigen::Vector3f view(0, 1, 0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  cloud.push_back(At({0, 0, 50}, view));
  cloud.push_back(At({nan, 0, 0}, view));
  EstimateNormals(cloud);
  EXPECT_EQ(cloud[1000].normal, view);
  EXPECT_EQ(cloud[1001].normal, view);
  EXPECT_LT(AngleDeg(cloud[0].normal, {0, 0, 1}), 0.1);
}

TEST(EstimateNormals, DuplicatesDoNotDisturbThePlane) {
  PointCloud cloud = Plane({0, 0, 1}, 500, 0, Eigen::Vector3f::Zero());
  for (int i = 0; i < 500; ++i) cloud.push_back(cloud[static_cast<std::size_t>(i)]);
  EstimateNormals(cloud, 24);
  for (const Point& p : cloud) ASSERT_LT(AngleDeg(p.normal, {0, 0, 1}), 0.1);
}

TEST(EstimateNormals, RejectsTooFewNeighbors) {
  PointCloud cloud;
  EXPECT_THROW(EstimateNormals(cloud, 4), std::invalid_argument);
}

TEST(PointSpacing, GridHasItsPitch) {
  PointCloud cloud;
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) {
      cloud.push_back(
          At({0.5f * static_cast<float>(x), 0.5f * static_cast<float>(y), 0}, {0, 0, 1}));
    }
  }
  const std::vector<float> spacing = PointSpacing(cloud, 2);
  for (float s : spacing) EXPECT_FLOAT_EQ(s, 0.5f);
}

TEST(PointIndex, AgreesWithBruteForce) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Eigen::Vector3f> points(500);
  for (auto& p : points) p = {uniform(rng), uniform(rng), uniform(rng)};
  const PointIndex index(points);
  std::vector<PointIndex::Neighbor> neighbors;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3f q(uniform(rng), uniform(rng), uniform(rng));
    std::vector<float> d2;
    for (const auto& p : points) d2.push_back((p - q).squaredNorm());
    std::sort(d2.begin(), d2.end());
    index.Nearest(q, 70, &neighbors);
    ASSERT_EQ(neighbors.size(), 70u);
    for (std::size_t j = 0; j < 70; ++j) ASSERT_NEAR(neighbors[j].distance2, d2[j], 1e-6);
    ASSERT_NEAR(index.NearestDistance(q), std::sqrt(d2[0]), 1e-6);
  }
}

TEST(PointIndex, VisitsThoseNearUntilTold) {
  std::mt19937 rng(6);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<Eigen::Vector3f> points(500);
  for (auto& p : points) p = {uniform(rng), uniform(rng), uniform(rng)};
  const PointIndex index(points);
  const Eigen::Vector3f query(0.1F, -0.2F, 0.3F);
  constexpr float kRadius = 0.5F;
  std::set<std::uint32_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - query).norm() < kRadius) near.insert(static_cast<std::uint32_t>(i));
  }
  ASSERT_GT(near.size(), 10);
  std::set<std::uint32_t> visited;
  index.VisitNear(query, kRadius, [&](const PointIndex::Neighbor& n) {
    EXPECT_FLOAT_EQ(n.distance2, (points[n.index] - query).squaredNorm());
    EXPECT_TRUE(visited.insert(n.index).second) << "twice: " << n.index;
    return true;
  });
  EXPECT_EQ(visited, near);
  int calls = 0;
  index.VisitNear(query, kRadius, [&](const PointIndex::Neighbor&) { return ++calls < 3; });
  EXPECT_EQ(calls, 3);
}

TEST(PointIndex, EmptyAndBrokenSets) {
  const PointIndex index({});
  EXPECT_EQ(index.NearestDistance({0, 0, 0}), std::numeric_limits<float>::infinity());
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_THROW(PointIndex({{0, inf, 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
