#include "livemvs/mesh/marching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "livemvs/mesh/mesh_test_util.h"
#include "livemvs/mesh/mesh_topology.h"

namespace livemvs {
namespace {

/// A cube of so many voxels each way, with values by a function of the voxel.
template <typename F>
SurfaceField MakeField(int side, const F& value) {
  SurfaceField field;
  field.frame.h = 1.0 / side;
  field.frame.size = Voxel::Constant(side);
  std::vector<VoxelBlocks::Key> keys;
  const int blocks = (side + VoxelBlocks::kSide - 1) / VoxelBlocks::kSide;
  for (int z = 0; z < blocks; ++z) {
    for (int y = 0; y < blocks; ++y) {
      for (int x = 0; x < blocks; ++x) keys.push_back(VoxelBlocks::KeyOf({x, y, z}));
    }
  }
  field.blocks = VoxelBlocks(keys);
  field.values.resize(field.blocks.voxels());
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    const Voxel v = field.blocks.VoxelAt(static_cast<std::int64_t>(i));
    const bool rim = (v.array() == 0).any() || (v.array() >= side - 1).any();
    field.values[i] = rim ? 1.0F : value(v);
  }
  return field;
}

void ExpectSound(const TriangleMesh& mesh) {
  const MeshTopology topology(mesh);
  EXPECT_EQ(topology.bad_edges(), 0u);
  EXPECT_EQ(topology.border_edges(), 0u);
  EXPECT_TRUE(PinchedVertices(mesh, topology).empty());
  EXPECT_TRUE(IntersectingFaces(mesh).empty());
}

TEST(March, EveryFieldGivesASoundSurface) {
  // Random signs: all sets of corners and all pairs of neighbours come up.
  std::mt19937 random(1);
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    std::uniform_real_distribution<double> number;
    const SurfaceField field = MakeField(24, [&](const Voxel&) {
      const auto size = static_cast<float>(0.001 + number(random));
      return number(random) < share ? -size : size;
    });
    const TriangleMesh mesh = MarchField(field, {});
    EXPECT_GT(mesh.faces.size(), 3000u);
    ExpectSound(mesh);
    EXPECT_GT(SignedVolume(mesh), 0);
  }
}

TEST(March, SphereLiesWhereItsZerosAre) {
  constexpr int kSide = 40;
  constexpr double kBallRadius = 13.3;
  const Eigen::Vector3d center = Eigen::Vector3d::Constant(kSide / 2.0 + 0.2);
  const SurfaceField field = MakeField(kSide, [&](const Voxel& v) {
    return static_cast<float>((v.cast<double>().array() + 0.5 - center.array()).matrix().norm() -
                              kBallRadius);
  });
  const TriangleMesh mesh = MarchField(field, {});
  ExpectSound(mesh);
  std::size_t components = 0;
  MeshTopology(mesh).Components(&components);
  EXPECT_EQ(components, 1u);
  double worst = 0;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    worst = std::max(worst, std::abs((v.cast<double>() * kSide - center).norm() - kBallRadius));
  }
  EXPECT_LT(worst, 0.06);  // voxels: the ends of lines are kept free, and fans have a middle
  constexpr double kPi = 3.14159265358979;
  EXPECT_NEAR(SignedVolume(mesh) / 6 * std::pow(kSide, 3),
              4.0 / 3 * kPi * std::pow(kBallRadius, 3),
              0.01 * 4.0 / 3 * kPi * std::pow(kBallRadius, 3));
  // Euler: a sphere.
  EXPECT_EQ(static_cast<long>(mesh.vertices.size()) - static_cast<long>(mesh.faces.size()) / 2, 2);
}

TEST(March, NothingGivesNothing) {
  EXPECT_TRUE(MarchField(MakeField(8, [](const Voxel&) { return 1.0F; }), {}).faces.empty());
}

}  // namespace
}  // namespace livemvs
