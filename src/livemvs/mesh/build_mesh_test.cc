#include "livemvs/mesh/build_mesh.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <limits>
#include <string>

#include "livemvs/core/error.h"
#include "livemvs/mesh/mesh_test_util.h"

namespace livemvs {
namespace {

constexpr double kRadius = 0.1;

void ExpectSound(const BuiltMesh& built) {
  EXPECT_EQ(built.statistics.bad_edges, 0u);
  EXPECT_EQ(built.statistics.pinched, 0u);
  EXPECT_EQ(built.statistics.intersections, 0u);
}

std::string FailureOf(const PointCloud& cloud, const MeshCameras& cameras) {
  try {
    BuildMesh(cloud, cameras, {}, {});
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kBadInput);
    return e.what();
  }
  return "none";
}

/// A sphere that cameras all around have seen.
CloudMaker Sphere(double sigma, int points) {
  CloudMaker maker(sigma);
  AddCamerasAround(0.5, &maker);
  maker.AddSphere(Eigen::Vector3d::Zero(), kRadius, points);
  return maker;
}

double WorstDistanceToSphere(const TriangleMesh& mesh, double share) {
  std::vector<double> distance;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    distance.push_back(std::abs(v.cast<double>().norm() - kRadius));
  }
  std::ranges::sort(distance);
  return distance[static_cast<std::size_t>(share * static_cast<double>(distance.size() - 1))];
}

TEST(BuildMesh, SphereIsClosedSoundAndWhereItIs) {
  constexpr double kSigma = 0.0008;
  const CloudMaker maker = Sphere(kSigma, 20000);
  CloudMaker copy = maker;
  const BuiltMesh built = BuildMesh(copy.cloud(), maker.cameras(), {}, {});
  ExpectSound(built);
  EXPECT_EQ(built.statistics.border_edges, 0u);
  EXPECT_EQ(built.statistics.points_seen, 20000u);
  EXPECT_GT(SignedVolume(built.mesh), 0);
  // Neighbours average: closer than a single point is in the mean, and nowhere far off.
  EXPECT_LT(WorstDistanceToSphere(built.mesh, 0.8), kSigma);
  EXPECT_LT(WorstDistanceToSphere(built.mesh, 1), 4 * kSigma);
  ASSERT_EQ(built.mesh.colors.size(), built.mesh.vertices.size());
  EXPECT_EQ(built.mesh.colors[0], (Rgb{200, 100, 50}));
}

TEST(BuildMesh, DoesNotDependOnTheNumberOfThreads) {
  CloudMaker maker = Sphere(0.001, 8000);
  BuiltMesh one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = BuildMesh(maker.cloud(), maker.cameras(), {}, {});
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 5);
  const BuiltMesh many = BuildMesh(maker.cloud(), maker.cameras(), {}, {});
  EXPECT_EQ(one.mesh.vertices, many.mesh.vertices);
  EXPECT_EQ(one.mesh.faces, many.mesh.faces);
  EXPECT_EQ(one.mesh.colors, many.mesh.colors);
}

/// A table of 0.4 x 0.4 seen from above, with a box of 0.1 on it; no points on the box's back.
CloudMaker BoxOnTable(int points) {
  CloudMaker maker(0.0005);
  const Eigen::Vector3d target(0, 0, 0.03);
  for (const double x : {-0.3, -0.1, 0.1, 0.3}) maker.AddCamera({x, -0.5, 0.4}, target);
  const auto frame = [&] { return static_cast<std::int32_t>(maker.random()() % 4); };
  for (int i = 0; i < points; ++i) {
    const double u = maker.Uniform(-0.2, 0.2), v = maker.Uniform(-0.2, 0.2);
    // What the box covers and hides - at its back the table - has no points.
    const bool covered = std::abs(u) < 0.07 && v > -0.05 && v < 0.19;
    if (!covered) maker.AddPoint({u, v, 0}, Eigen::Vector3d::UnitZ(), frame());
    if (i % 6 == 0) {
      maker.AddPoint({u / 4, v / 4, 0.1}, Eigen::Vector3d::UnitZ(), frame());
      maker.AddPoint({u / 4, -0.05, 0.05 + v / 4}, -Eigen::Vector3d::UnitY(), frame());
    }
  }
  return maker;
}

bool HasVertexNear(const TriangleMesh& mesh, const Eigen::Vector3f& at, float distance) {
  return std::ranges::any_of(mesh.vertices,
                             [&](const Eigen::Vector3f& v) { return (v - at).norm() < distance; });
}

TEST(BuildMesh, IsOpenWhereNothingWasSeenAndClosedOnRequest) {
  CloudMaker maker = BoxOnTable(20000);
  MeshOptions options;
  const BuiltMesh open = BuildMesh(maker.cloud(), maker.cameras(), options, {});
  ExpectSound(open);
  EXPECT_GT(open.statistics.border_edges, 100u);
  EXPECT_TRUE(HasVertexNear(open.mesh, {0, 0, 0.1F}, 0.004F));
  EXPECT_TRUE(HasVertexNear(open.mesh, {0, -0.05F, 0.05F}, 0.004F));
  EXPECT_TRUE(HasVertexNear(open.mesh, {-0.15F, -0.1F, 0}, 0.004F));
  EXPECT_FALSE(HasVertexNear(open.mesh, {0, 0.05F, 0.05F}, 0.03F));   // the box's back
  EXPECT_FALSE(HasVertexNear(open.mesh, {0, 0.11F, 0.02F}, 0.025F));  // what it hides
  options.whole_surface = true;
  const BuiltMesh closed = BuildMesh(maker.cloud(), maker.cameras(), options, {});
  ExpectSound(closed);
  EXPECT_EQ(closed.statistics.border_edges, 0u);
  EXPECT_GT(SignedVolume(closed.mesh), 0);
}

TEST(BuildMesh, BridgesAGapThatCamerasLookInto) {
  // A plane whose middle has no texture, thus no points.
  CloudMaker maker(0.0003);
  for (const double x : {-0.3, -0.1, 0.1, 0.3}) maker.AddCamera({x, 0, 0.5}, {0, 0, 0});
  for (int i = 0; i < 15000; ++i) {
    const double u = maker.Uniform(-0.15, 0.15), v = maker.Uniform(-0.15, 0.15);
    if (std::hypot(u, v) < 0.01) continue;
    maker.AddPoint({u, v, 0}, Eigen::Vector3d::UnitZ(), static_cast<std::int32_t>(i % 4));
  }
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), {}, {});
  ExpectSound(built);
  EXPECT_TRUE(HasVertexNear(built.mesh, {0, 0, 0}, 0.002F));
}

TEST(BuildMesh, HolesThatCamerasSeeThroughStayOpen) {
  // A thin plate over a table, and in it a hole that is not much wider than a coarse voxel.
  constexpr double kHole = 0.0035, kAbove = 0.012;
  CloudMaker maker(0.0003);
  for (const double x : {-0.3, -0.1, 0.1, 0.3}) maker.AddCamera({x, 0, 0.6}, {0, 0, 0});
  for (int i = 0; i < 60000; ++i) {
    const double u = maker.Uniform(-0.15, 0.15), v = maker.Uniform(-0.15, 0.15);
    const auto frame = static_cast<std::int32_t>(i % 4);
    const bool hole = std::hypot(u, v) < kHole;
    if (!hole) maker.AddPoint({u, v, kAbove}, Eigen::Vector3d::UnitZ(), frame);
    // The table, as it is seen through the hole.
    const Eigen::Vector3d center = maker.cameras().at(frame).cam_from_world.Center();
    const Eigen::Vector3d below =
        center + (Eigen::Vector3d(u, v, kAbove) - center) * (center.z() / (center.z() - kAbove));
    for (int n = 0; hole && n < 20; ++n) maker.AddPoint(below, Eigen::Vector3d::UnitZ(), frame);
  }
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), {}, {});
  ExpectSound(built);
  EXPECT_TRUE(HasVertexNear(built.mesh, {0.05F, 0, 0.012F}, 0.002F));
  EXPECT_FALSE(HasVertexNear(built.mesh, {0, 0, 0.012F}, 0.0018F));
}

TEST(BuildMesh, KeepsPartsWithFewerPoints) {
  // Voxels follow the usual spacing of the points, which is a third of that on the smaller sphere.
  CloudMaker maker(0.0005);
  const Eigen::Vector3d center(0.2, 0, 0);
  AddCamerasAround(0.6, &maker);
  maker.AddSphere(Eigen::Vector3d::Zero(), kRadius, 40000);
  maker.AddSphere(center, 0.3 * kRadius, 400);
  const auto share_near = [&](const TriangleMesh& mesh) {
    constexpr int kRings = 12;
    int near = 0, all = 0;
    for (int i = 1; i < kRings; ++i) {
      for (int j = 0; j < 2 * kRings; ++j, ++all) {
        const double theta = M_PI * i / kRings, phi = M_PI * j / kRings;
        const Eigen::Vector3d n(
            std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        const Eigen::Vector3d at = center + 0.3 * kRadius * n;
        near += HasVertexNear(mesh, at.cast<float>(), 0.004F) ? 1 : 0;
      }
    }
    return static_cast<double>(near) / all;
  };
  MeshOptions options;
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), options, {});
  ExpectSound(built);
  EXPECT_GT(share_near(built.mesh), 0.9);
  options.coarse_trust = 0;
  EXPECT_LT(share_near(BuildMesh(maker.cloud(), maker.cameras(), options, {}).mesh), 0.5);
}

TEST(BuildMesh, DecimatesToSoManyFaces) {
  CloudMaker maker = Sphere(0.0005, 10000);
  MeshOptions options;
  options.faces = 1000;
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), options, {});
  ExpectSound(built);
  EXPECT_LE(built.mesh.faces.size(), 1000u);
  EXPECT_GT(built.mesh.faces.size(), 700u);
  EXPECT_LT(WorstDistanceToSphere(built.mesh, 1), 0.003);
}

TEST(BuildMesh, RefusesCloudsWithoutASurface) {
  EXPECT_NE(FailureOf({}, {}).find("at least 10 points"), std::string::npos);
  CloudMaker maker = Sphere(0.001, 3);
  EXPECT_NE(FailureOf(maker.cloud(), maker.cameras()).find("at least 10 points"),
            std::string::npos);
  PointCloud line(100);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line[i].position = {static_cast<float>(i), 2 * static_cast<float>(i), 0};
    line[i].normal = {0, 0, 1};
  }
  EXPECT_NE(FailureOf(line, {}).find("one line"), std::string::npos);
  const PointCloud same(1000, line[0]);
  EXPECT_NE(FailureOf(same, {}).find("repeated (999)"), std::string::npos);
  PointCloud nameless = Sphere(0.001, 500).cloud();
  for (Point& p : nameless) p.normal.setZero();
  EXPECT_NE(FailureOf(nameless, {}).find("neither"), std::string::npos);
}

TEST(BuildMesh, LeavesOutWhatIsNoPointOfTheSurface) {
  CloudMaker maker = Sphere(0.0008, 8000);
  PointCloud& cloud = maker.cloud();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 50; ++i) {
    cloud.push_back(cloud[static_cast<std::size_t>(i)]);  // again
    Point broken = cloud[static_cast<std::size_t>(i)];
    broken.position[i % 3] = i % 2 == 0 ? nan : std::numeric_limits<float>::infinity();
    cloud.push_back(broken);
  }
  Point far = cloud[0];
  far.position = {1000, 0, 0};  // 1 km away
  cloud.push_back(far);
  for (std::size_t i = 0; i < 40; ++i) {  // numbers that are none, beside good positions
    cloud[i].sigma = nan;
    cloud[i].inlier_ratio = -nan;
    cloud[i].normal = {nan, 0, 0};
    cloud[i].frame = 123456;  // of no camera
  }
  const BuiltMesh built = BuildMesh(cloud, maker.cameras(), {}, {});
  EXPECT_EQ(built.statistics.not_finite, 50u);
  EXPECT_EQ(built.statistics.repeated, 50u);
  EXPECT_EQ(built.statistics.lonely, 1u);
  ExpectSound(built);
  EXPECT_LT(WorstDistanceToSphere(built.mesh, 1), 0.004);
}

TEST(BuildMesh, OutliersThatFlockTakeNoSpace) {
  // Too many in one place to be lonely: the box is 1 km long, the bands are not.
  CloudMaker maker = Sphere(0.0008, 8000);
  Point far = maker.cloud()[0];
  for (int i = 0; i < 30; ++i) {
    far.position = Eigen::Vector3f(1000 + 0.001F * static_cast<float>(i % 6),
                                   0.001F * static_cast<float>(i / 6),
                                   0.0001F * static_cast<float>(i));
    maker.cloud().push_back(far);
  }
  MeshOptions options;
  options.memory_mb = 500;
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), options, {});
  ExpectSound(built);
  EXPECT_LT(built.statistics.voxels, 1'000'000u);
  EXPECT_LT(WorstDistanceToSphere(built.mesh, 0.99), 0.004);
}

TEST(BuildMesh, PlaneIsAPlane) {
  CloudMaker maker(0);
  for (const double x : {-0.1, 0.1}) maker.AddCamera({x, 0, 0.4}, {0, 0, 0});
  for (int i = 0; i < 5000; ++i) {
    maker.AddPoint(
        {maker.Uniform(-0.1, 0.1), maker.Uniform(-0.1, 0.1), 0}, Eigen::Vector3d::UnitZ(), i % 2);
  }
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), {}, {});
  ExpectSound(built);
  for (const Eigen::Vector3f& v : built.mesh.vertices) {
    if (std::abs(v.x()) > 0.09F || std::abs(v.y()) > 0.09F) continue;
    EXPECT_NEAR(v.z(), 0, 5e-4);
  }
}

TEST(BuildMesh, NormalsStandForLinesOfSight) {
  CloudMaker maker = Sphere(0.0005, 10000);
  for (Point& p : maker.cloud()) p.frame = -1;
  const BuiltMesh built = BuildMesh(maker.cloud(), {}, {}, {});
  EXPECT_EQ(built.statistics.points_seen, 0u);
  ExpectSound(built);
  EXPECT_LT(WorstDistanceToSphere(built.mesh, 0.99), 0.003);
}

TEST(BuildMesh, VoxelsGrowToFitTheMemory) {
  CloudMaker maker = Sphere(0.0003, 60000);
  MeshOptions options;
  options.resolution = 0.0003;
  options.memory_mb = 60;
  const BuiltMesh built = BuildMesh(maker.cloud(), maker.cameras(), options, {});
  EXPECT_GT(built.statistics.voxel, 0.0004);
  EXPECT_LT(built.statistics.voxels, 4'000'000u);
  ExpectSound(built);
}

TEST(BuildMesh, StopsWhenTold) {
  CloudMaker maker = Sphere(0.001, 5000);
  int asked = 0;
  MeshWatch watch;
  watch.stop = [&] { return ++asked > 5; };
  EXPECT_THROW(BuildMesh(maker.cloud(), maker.cameras(), {}, watch), MeshInterrupted);
}

TEST(BuildMesh, RefusesWrongOptions) {
  MeshOptions options;
  options.lambda = -1;
  EXPECT_THROW(options.Check(), std::invalid_argument);
  options = {};
  options.resolution = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(options.Check(), std::invalid_argument);
  options = {};
  options.memory_mb = 1;
  EXPECT_THROW(options.Check(), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
