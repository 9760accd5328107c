#include "livemvs/mesh/mesh_topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "livemvs/mesh/simplify.h"
#include "livemvs/mesh/voxel_blocks.h"

namespace livemvs {
namespace {

using ::testing::ElementsAre;

TriangleMesh MakeMesh(std::vector<Eigen::Vector3f> vertices, std::vector<Eigen::Vector3i> faces) {
  TriangleMesh mesh;
  mesh.vertices = std::move(vertices);
  mesh.faces = std::move(faces);
  return mesh;
}

TEST(MeshTopology, FindsEdgesOfThreeFaces) {
  const TriangleMesh mesh = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}},
                                     {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  const MeshTopology topology(mesh);
  EXPECT_EQ(topology.bad_edges(), 1u);
  EXPECT_EQ(topology.border_edges(), 6u);
}

TEST(MeshTopology, FindsFacesThatLookTheOtherWay) {
  const std::vector<Eigen::Vector3f> vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  EXPECT_EQ(MeshTopology(MakeMesh(vertices, {{0, 1, 2}, {1, 0, 3}})).bad_edges(), 0u);
  EXPECT_EQ(MeshTopology(MakeMesh(vertices, {{0, 1, 2}, {0, 1, 3}})).bad_edges(), 1u);
}

TEST(MeshTopology, FindsPinchesAndRemovesTheSmallerFan) {
  TriangleMesh mesh =
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 0, 1}, {-1, -1, 1}},
               {{0, 1, 2}, {0, 2, 3}, {0, 4, 5}});
  const MeshTopology topology(mesh);
  EXPECT_THAT(PinchedVertices(mesh, topology), ElementsAre(0));
  std::vector<char> marks(3, 0);
  EXPECT_EQ(MarkPinches(mesh, topology, &marks), 1u);
  RemoveFaces(marks, &mesh);
  EXPECT_EQ(mesh.faces.size(), 2u);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_TRUE(PinchedVertices(mesh, MeshTopology(mesh)).empty());
}

TEST(IntersectingFaces, FindsWhatPasses) {
  const std::vector<Eigen::Vector3f> vertices = {{0, 0, 0},
                                                 {1, 0, 0},
                                                 {0, 1, 0},
                                                 {0.2F, 0.2F, -1},
                                                 {0.3F, 0.2F, 1},
                                                 {0.2F, 0.4F, 1},
                                                 {5, 5, 5}};
  EXPECT_THAT(IntersectingFaces(MakeMesh(vertices, {{0, 1, 2}, {3, 4, 5}})),
              ElementsAre(std::array<std::int32_t, 2>{0, 1}));
  EXPECT_TRUE(IntersectingFaces(MakeMesh(vertices, {{0, 1, 2}, {0, 1, 6}})).empty());
  // With a corner in common, the edge opposite to it passes through.
  EXPECT_EQ(IntersectingFaces(MakeMesh(vertices, {{0, 1, 2}, {0, 3, 4}})).size(), 1u);
}

/// A torus of n x m quads.
TriangleMesh Torus(int n, int m) {
  TriangleMesh mesh;
  constexpr double kTurn = 6.283185307179586;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      const double u = kTurn * i / n, v = kTurn * j / m, r = 1 + 0.4 * std::cos(v);
      mesh.vertices.emplace_back(
          Eigen::Vector3d(r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)).cast<float>());
      const auto at = [&](int a, int b) { return (a % n) * m + b % m; };
      mesh.faces.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.faces.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return mesh;
}

TEST(IntersectingFaces, AgreesWithAllPairs) {
  // Torn at random, so that many faces intersect; the other way: no grid, every pair on its own.
  TriangleMesh mesh = Torus(16, 10);
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.2F);
  for (Eigen::Vector3f& v : mesh.vertices)
    v += Eigen::Vector3f(noise(random), noise(random), noise(random));
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    for (std::size_t j = i + 1; j < mesh.faces.size(); ++j) {
      pairs += IntersectingFaces(MakeMesh(mesh.vertices, {mesh.faces[i], mesh.faces[j]})).size();
    }
  }
  EXPECT_GT(pairs, 10u);
  EXPECT_EQ(IntersectingFaces(mesh).size(), pairs);
}

TEST(SimplifyMesh, KeepsATorusSound) {
  TriangleMesh mesh = Torus(120, 60);
  EXPECT_TRUE(SimplifyMesh(600, {}, &mesh));
  EXPECT_LE(mesh.faces.size(), 600u);
  EXPECT_GT(mesh.faces.size(), 400u);
  const MeshTopology topology(mesh);
  EXPECT_EQ(topology.bad_edges() + topology.border_edges(), 0u);
  EXPECT_TRUE(PinchedVertices(mesh, topology).empty());
  EXPECT_TRUE(IntersectingFaces(mesh).empty());
  EXPECT_EQ(mesh.vertices.size(), mesh.faces.size() / 2);  // Euler: a torus
  for (const Eigen::Vector3f& v : mesh.vertices) {
    EXPECT_NEAR(std::hypot(std::hypot(v.x(), v.y()) - 1, v.z()), 0.4, 1e-5);
  }
}

TEST(SimplifyMesh, DoesNotFoldThinSheetsOntoEachOther) {
  // Two wavy sheets close to each other: decimated freely they pass through each other.
  TriangleMesh mesh;
  constexpr int kSide = 60;
  for (const double offset : {0.0, 0.004}) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const double z = 0.05 * std::sin(0.5 * x) * std::cos(0.4 * y) + offset;
        mesh.vertices.emplace_back(
            static_cast<float>(x) / 60.0F, static_cast<float>(y) / 60.0F, static_cast<float>(z));
        if (x == 0 || y == 0) continue;
        const int at = first + y * kSide + x;
        mesh.faces.emplace_back(at, at - 1, at - kSide - 1);
        mesh.faces.emplace_back(at, at - kSide - 1, at - kSide);
      }
    }
  }
  ASSERT_TRUE(IntersectingFaces(mesh).empty());
  SimplifyMesh(1500, {}, &mesh);
  EXPECT_TRUE(IntersectingFaces(mesh).empty());
  EXPECT_EQ(MeshTopology(mesh).bad_edges(), 0u);
}

TEST(VoxelBlocks, FindsWhatIsThere) {
  std::mt19937 random(1);
  std::vector<VoxelBlocks::Key> keys;
  for (int i = 0; i < 1000; ++i) {
    keys.push_back(
        VoxelBlocks::KeyOf({static_cast<int>(random() % 30),
                            static_cast<int>(random() % 30),
                            VoxelBlocks::kMostBlocks - 1 - static_cast<int>(random() % 9)}));
  }
  const VoxelBlocks blocks(keys);
  EXPECT_LT(blocks.blocks(), 1000u);
  VoxelCursor cursor(blocks);
  for (std::size_t i = 0; i < blocks.voxels(); i += 7) {
    const auto number = static_cast<std::int64_t>(i);
    EXPECT_EQ(blocks.Find(blocks.VoxelAt(number)), number);
    EXPECT_EQ(cursor.Find(blocks.VoxelAt(number)), number);
  }
  EXPECT_EQ(blocks.Find({-1, 0, 0}), VoxelBlocks::kNone);
  EXPECT_EQ(cursor.Find({-1, 0, 0}), VoxelBlocks::kNone);
  EXPECT_EQ(blocks.Find({200, 0, 0}), VoxelBlocks::kNone);
  EXPECT_EQ(VoxelBlocks().Find({0, 0, 0}), VoxelBlocks::kNone);
}

}  // namespace
}  // namespace livemvs
