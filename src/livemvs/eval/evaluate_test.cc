#include "livemvs/eval/evaluate.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "livemvs/eval/report.h"
#include "livemvs/eval/split_mix.h"

namespace livemvs {
namespace {

/// The unit cube [0, 1]^3.
TriangleMesh UnitCube() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(
        static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2));
  }
  const int quads[6][4] = {
      {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    mesh.faces.emplace_back(q[0], q[1], q[2]);
    mesh.faces.emplace_back(q[0], q[2], q[3]);
  }
  return mesh;
}

/// A square of side 2 about the origin at the given height.
TriangleMesh Square(float z) {
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Distance to the unit cube's surface in closed form.
double CubeDistance(const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = (p.array() - 0.5).abs() - 0.5;
  const double outside = q.cwiseMax(0).norm();
  return outside > 0 ? outside : -q.maxCoeff();
}

PointCloud Grid(float z, int n) {
  PointCloud cloud;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      Point p;
      p.position = {-1 + 2 * (static_cast<float>(x) + 0.5f) / static_cast<float>(n),
                    -1 + 2 * (static_cast<float>(y) + 0.5f) / static_cast<float>(n),
                    z};
      cloud.push_back(p);
    }
  }
  return cloud;
}

Eigen::Vector3d UniformVector(SplitMix64* random) {
  const double x = random->Uniform(), y = random->Uniform(), z = random->Uniform();
  return {x, y, z};
}

TEST(MeshSurface, DistanceToACubeIsExact) {
  const MeshSurface cube(UnitCube());
  SplitMix64 random(1);
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d p = UniformVector(&random) * 4 - Eigen::Vector3d::Constant(1.5);
    ASSERT_NEAR(cube.Distance(p), CubeDistance(p), 1e-12) << p.transpose();
  }
}

/// 200 small triangles at random, and one without area.
TriangleMesh Soup(SplitMix64* random) {
  TriangleMesh soup;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d at = UniformVector(random);
    for (int c = 0; c < 3; ++c) {
      soup.vertices.push_back((at + 0.2 * UniformVector(random)).cast<float>());
    }
    soup.faces.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  soup.faces.emplace_back(0, 0, 1);
  return soup;
}

TEST(MeshSurface, DistanceAndSightAgreeWithBruteForceOnTriangleSoup) {
  SplitMix64 random(2);
  const TriangleMesh soup = Soup(&random);
  const MeshSurface surface(soup);
  const auto corner = [&](const Eigen::Vector3i& f, int c) -> Eigen::Vector3d {
    return soup.vertices[static_cast<std::size_t>(f[c])].cast<double>();
  };
  int blocked = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p = 1.4 * UniformVector(&random), to = 1.4 * UniformVector(&random);
    double nearest = std::numeric_limits<double>::infinity();
    double first = nearest;
    for (const Eigen::Vector3i& f : soup.faces) {
      const Eigen::Vector3d a = corner(f, 0), e1 = corner(f, 1) - a, e2 = corner(f, 2) - a;
      nearest = std::min(nearest, PointTriangleDistance(p, a, a + e1, a + e2));
      // Solve p + t (to - p) = a + u e1 + v e2.
      Eigen::Matrix3d m;
      m << p - to, e1, e2;
      if (std::abs(m.determinant()) < 1e-12) continue;
      const Eigen::Vector3d tuv = m.inverse() * (p - a);
      if (tuv[0] > 0 && tuv[1] >= 0 && tuv[2] >= 0 && tuv[1] + tuv[2] <= 1) {
        first = std::min(first, tuv[0]);
      }
    }
    ASSERT_NEAR(surface.Distance(p), nearest, 1e-6);
    if (std::abs(first - 1) < 1e-3) continue;  // decided by rounding
    const Eigen::Vector3f origin = p.cast<float>(), direction = (to - p).cast<float>();
    ASSERT_EQ(surface.IsBlocked(origin, direction, 1), first < 1);
    const auto hit = surface.FirstHit(origin, direction);
    ASSERT_EQ(hit.has_value(), std::isfinite(first));
    if (hit) {
      ASSERT_NEAR(hit->distance, first, 1e-3 * std::max(1.0, first));
    }
    blocked += first < 1;
  }
  EXPECT_GT(blocked, 100);
  EXPECT_LT(blocked, 1900);
}

TEST(PointTriangleDistance, FeaturesInClosedForm) {
  const Eigen::Vector3d a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  EXPECT_DOUBLE_EQ(PointTriangleDistance({0.5, 0.5, 3}, a, b, c), 3);           // face
  EXPECT_DOUBLE_EQ(PointTriangleDistance({1, -2, 0}, a, b, c), 2);              // edge
  EXPECT_DOUBLE_EQ(PointTriangleDistance({-3, -4, 0}, a, b, c), 5);             // corner
  EXPECT_NEAR(PointTriangleDistance({2, 2, 0}, a, b, c), std::sqrt(2), 1e-15);  // long edge
  EXPECT_DOUBLE_EQ(PointTriangleDistance({1, 1, 1}, a, a, a), std::sqrt(3));    // a point
  EXPECT_DOUBLE_EQ(PointTriangleDistance({1, 4, 0}, a, b, b), 4);               // a segment
}

TEST(MeshSurface, SamplesAreEvenAndKeepToTheBox) {
  const MeshSurface cube(UnitCube());
  const auto all = cube.Sample(60000, 3, std::nullopt);
  ASSERT_EQ(all.size(), 60000u);
  int top = 0, low_half_of_top = 0;
  for (const Eigen::Vector3f& p : all) {
    ASSERT_LT(CubeDistance(p.cast<double>()), 1e-6);
    if (p.z() > 0.999999f) {
      ++top;
      low_half_of_top += p.x() < 0.5f;
    }
  }
  // Binomial: 10 000 and half of that, within five standard deviations.
  EXPECT_NEAR(top, 10000, 5 * std::sqrt(60000 * 5 / 36.0));
  EXPECT_NEAR(low_half_of_top, top / 2.0, 5 * std::sqrt(top / 4.0));

  const Box box{{-1, -1, 0.9}, {2, 2, 2}};
  const auto some = cube.Sample(1000, 3, box);
  ASSERT_EQ(some.size(), 1000u);
  for (const Eigen::Vector3f& p : some) ASSERT_TRUE(box.Contains(p.cast<double>()));
  EXPECT_EQ(some, cube.Sample(1000, 3, box));
  EXPECT_NE(some, cube.Sample(1000, 4, box));
  EXPECT_TRUE(cube.Sample(1000, 3, Box{{5, 5, 5}, {6, 6, 6}}).empty());
}

TEST(MeshSurface, RejectsBrokenMeshes) {
  EXPECT_THROW(MeshSurface(TriangleMesh{}), std::invalid_argument);
  TriangleMesh mesh = UnitCube();
  mesh.faces.emplace_back(0, 1, 8);
  EXPECT_THROW(MeshSurface{mesh}, std::invalid_argument);
  mesh.faces.back() = {0, -1, 2};
  EXPECT_THROW(MeshSurface{mesh}, std::invalid_argument);
  mesh = UnitCube();
  mesh.vertices[3].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(MeshSurface{mesh}, std::invalid_argument);
}

TEST(Evaluate, PlaneOffsetByAKnownAmount) {
  const Evaluation e =
      EvaluateAgainstMesh(Grid(0.25f, 200), MeshSurface(Square(0)), {}, EvaluationOptions{});
  ASSERT_EQ(e.accuracy.size(), 40000u);
  ASSERT_EQ(e.completeness.size(), 200000u);
  EXPECT_NEAR(*Percentile(e.accuracy, 0), 0.25, 1e-6);
  EXPECT_NEAR(*Percentile(e.accuracy, 100), 0.25, 1e-6);
  EXPECT_EQ(ShareWithin(e.accuracy, 0.2499), 0);
  EXPECT_EQ(ShareWithin(e.accuracy, 0.2501), 1);
  EXPECT_GE(e.completeness.front(), 0.25f - 1e-6f);
  EXPECT_LE(e.completeness.back(), std::hypot(0.25f, 0.005f * std::sqrt(2.0f)) + 1e-5f);
}

TEST(Evaluate, HalfOfTheSurfaceIsMissing) {
  PointCloud half;
  for (const Point& p : Grid(0, 200)) {
    if (p.position.x() < 0) half.push_back(p);
  }
  const Evaluation e = EvaluateAgainstMesh(half, MeshSurface(Square(0)), {}, EvaluationOptions{});
  EXPECT_EQ(ShareWithin(e.accuracy, 0.01), 1);
  // The half, and beside it what the discs of radius 0.01 about the outermost points cover, which
  // are 0.01 apart and 0.005 inside: the mean of sqrt(1 - u^2) over |u| < 1/2, less the 0.005.
  const double strip = 0.01 * (M_PI / 6 + std::sqrt(3.0) / 4) - 0.005;
  EXPECT_NEAR(ShareWithin(e.completeness, 0.01), (1 + strip) / 2, 5 * std::sqrt(0.25 / 200000));
  EXPECT_NEAR(FScore(1, 0.5), 2.0 / 3, 1e-15);
  EXPECT_EQ(FScore(0, 0), 0);
}

TEST(Evaluate, SphereAgainstACloudOfASphere) {
  SplitMix64 random(4);
  const auto sphere = [&](int n, double radius) {
    PointCloud cloud(static_cast<std::size_t>(n));
    for (Point& p : cloud) {
      const double z = 2 * random.Uniform() - 1, angle = 2 * M_PI * random.Uniform();
      const double r = std::sqrt(1 - z * z);
      const Eigen::Vector3d on_unit(r * std::cos(angle), r * std::sin(angle), z);
      p.position = (radius * on_unit).cast<float>();
    }
    return cloud;
  };
  const Evaluation e = EvaluateAgainstCloud(sphere(2000, 1.1), sphere(50000, 1), {});
  EXPECT_GE(e.accuracy.front(), 0.1f - 1e-5f);
  EXPECT_NEAR(*Percentile(e.accuracy, 50), 0.1, 2e-3);  // reference spacing is 0.016
  EXPECT_EQ(e.completeness.size(), 50000u);
  EXPECT_GE(e.completeness.front(), 0.1f - 1e-5f);
}

TEST(Evaluate, MeshIsMeasuredByItsAreaAndItsSurface) {
  // Two triangles, 0.01 above the reference: vertices alone would leave nearly all uncovered.
  const MeshSurface reference(Square(0));
  const Evaluation same = EvaluateMesh(Square(0.01F), reference, {}, {});
  EXPECT_EQ(same.points, EvaluationOptions{}.samples);
  EXPECT_NEAR(*Percentile(same.accuracy, 100), 0.01, 1e-6);
  EXPECT_NEAR(*Percentile(same.completeness, 100), 0.01, 1e-6);
  // One of the two triangles, in the box that holds a quarter of the square.
  TriangleMesh half = Square(0);
  half.faces.pop_back();
  EvaluationOptions options;
  options.box = Box{{-1, -1, -1}, {0, 0, 1}};
  options.samples = 20000;
  const Evaluation part = EvaluateMesh(half, reference, {}, options);
  EXPECT_NEAR(ShareWithin(part.completeness, 1e-5), 0.5, 0.01);
  EXPECT_EQ(ShareWithin(part.accuracy, 1e-5), 1);
  // Against a cloud, and with a vertex that is no number.
  half.vertices[3].x() = std::numeric_limits<float>::quiet_NaN();
  const Evaluation cloud = EvaluateMesh(half, Grid(0.02F, 40), {});
  EXPECT_EQ(cloud.not_finite, 1u);
  EXPECT_GT(*Percentile(cloud.accuracy, 0), 0.0199);
  EXPECT_NEAR(ShareWithin(cloud.completeness, 0.0201), 0.5, 0.02);
  half.faces.clear();
  EXPECT_EQ(ShareWithin(EvaluateMesh(half, reference, {}, options).completeness, 100), 0);
}

TEST(Evaluate, EmptyOutsideAndBrokenPoints) {
  const MeshSurface square(Square(0));
  EvaluationOptions options;
  options.box = Box{{-1, -1, -0.5}, {1, 1, 0.5}};
  PointCloud cloud = Grid(3, 10);  // outside of the box
  cloud[0].position.x() = std::numeric_limits<float>::quiet_NaN();
  cloud[1].position.y() = -std::numeric_limits<float>::infinity();
  for (const PointCloud& c : {PointCloud{}, cloud}) {
    const Evaluation e = EvaluateAgainstMesh(c, square, {}, options);
    EXPECT_TRUE(e.accuracy.empty());
    EXPECT_EQ(e.completeness.size(), options.samples);
    EXPECT_TRUE(std::isinf(e.completeness.front()));
    EXPECT_EQ(Percentile(e.accuracy, 50), std::nullopt);
    EXPECT_EQ(ShareWithin(e.completeness, 1e9), 0);
    EXPECT_EQ(e.not_finite, c.empty() ? 0u : 2u);
    // Nothing to show must still be shown, and be JSON.
    EXPECT_NE(EvaluationTable(e, {}).find("no points"), std::string::npos);
    const auto json = nlohmann::json::parse(EvaluationJson(e, {}));
    EXPECT_TRUE(json["accuracy"]["percentiles"]["50"].is_null());
    EXPECT_TRUE(json["completeness"]["percentiles"]["50"].is_null());
    EXPECT_EQ(json["within"][0]["f_score"], 0);
    EvaluationPlot(e, "empty", {});
  }
}

TEST(Evaluate, ReportSpeaksInTheUnitAskedFor) {
  const Evaluation e =
      EvaluateAgainstMesh(Grid(0.25f, 20), MeshSurface(Square(0)), {}, EvaluationOptions{});
  ReportOptions report;
  report.unit = "cm";
  report.units_per_scene = 100;
  report.taus = {24, 26};
  const auto json = nlohmann::json::parse(EvaluationJson(e, report));
  EXPECT_NEAR(json["accuracy"]["percentiles"]["50"], 25, 1e-4);
  EXPECT_NEAR(json["accuracy"]["rms"], 25, 1e-4);
  EXPECT_EQ(json["within"][0]["accuracy"], 0);
  EXPECT_EQ(json["within"][1]["accuracy"], 1);
  EXPECT_EQ(json["points_in_box"], 400);
  const std::string table = EvaluationTable(e, report);
  EXPECT_NE(table.find("25.000"), std::string::npos) << table;
  EXPECT_NE(table.find("cm"), std::string::npos) << table;
}

TEST(Evaluate, OnlySurfaceThatEnoughCamerasSeeIsJudged) {
  // A square of side 2 with a roof of side 1 over its middle, and cameras high above.
  TriangleMesh mesh = Square(0);
  for (const Eigen::Vector3f& v : Square(0.01f).vertices) {
    mesh.vertices.push_back(v.cwiseProduct(Eigen::Vector3f(0.5f, 0.5f, 1)));
  }
  mesh.faces.emplace_back(4, 5, 6);
  mesh.faces.emplace_back(4, 6, 7);
  const MeshSurface surface(mesh);
  Camera camera;
  camera.width = camera.height = 1001;
  camera.fx = camera.fy = 900;
  camera.cx = camera.cy = 500;
  Rigid3d pose;  // 2 above, looking down
  pose.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  pose.translation = {0, 0, 2};
  std::vector<PosedCamera> cameras(5, {camera, pose});

  EvaluationOptions options;
  options.unblocked = 1 - 1e-4;
  const auto samples = surface.Sample(50000, 1, std::nullopt);
  const auto seen = SeenSamples(samples, surface, cameras, options);
  // All of the roof, area 1, and the square less the roof's shadow, area 4 - 1.01.
  EXPECT_NEAR(static_cast<double>(seen.size()) / 50000, 3.99 / 5, 5 * std::sqrt(0.16 / 50000));
  for (const Eigen::Vector3f& p : seen) {
    ASSERT_TRUE(p.z() > 0.005f || p.head<2>().cwiseAbs().maxCoeff() > 0.5f);
  }
  options.min_cameras = 6;
  EXPECT_TRUE(SeenSamples(samples, surface, cameras, options).empty());
  options.min_cameras = 5;
  cameras[2].cam_from_world.rotation = Eigen::Matrix3d::Identity();  // looks up
  cameras[2].cam_from_world.translation = {0, 0, -2};
  EXPECT_TRUE(SeenSamples(samples, surface, cameras, options).empty());
}

TEST(Evaluate, RejectsWrongOptions) {
  EvaluationOptions options;
  options.box = Box{{0, 0, 1}, {1, 1, 1}};
  EXPECT_THROW(options.Check(), std::invalid_argument);
  ReportOptions report;
  report.taus = {1, -1};
  EXPECT_THROW(report.Check(), std::invalid_argument);
}

TEST(Percentile, IsLinearBetweenNeighbours) {
  const std::vector<float> values = {0, 1, 2, 4};
  EXPECT_DOUBLE_EQ(*Percentile(values, 50), 1.5);
  EXPECT_DOUBLE_EQ(*Percentile(values, 100), 4);
  EXPECT_DOUBLE_EQ(*Percentile({3}, 80), 3);
  EXPECT_DOUBLE_EQ(ShareWithin(values, 1), 0.25);  // less than, not equal
}

}  // namespace
}  // namespace livemvs
