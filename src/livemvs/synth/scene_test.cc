#include "livemvs/synth/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "livemvs/synth/noise.h"

namespace livemvs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

const SyntheticScene& StillLife() {
  static const SyntheticScene scene({.name = "table"});
  return scene;
}

TEST(Scene, RaysMeetTheBallWhereAlgebraSays) {
  // The table's ball: radius 34 mm, standing on z = 0 at (-12, -28) mm.
  const Vector3d center(-0.012, -0.028, 0.034);
  for (const Vector3d& from : {Vector3d(0.1, -0.5, 0.4), Vector3d(-0.2, -0.4, 0.3)}) {
    const Vector3d direction = (center - from).normalized();
    SyntheticScene::Hit hit;
    ASSERT_TRUE(StillLife().Intersect(from, direction, &hit));
    EXPECT_EQ(StillLife().materials()[StillLife().MaterialOf(hit.face)].name, "ball");
    // Facets lie within the ball by the sagitta of a 96th of a turn: 0.02 mm.
    EXPECT_NEAR(hit.distance, (center - from).norm() - 0.034, 5e-5);
  }
}

TEST(Scene, FacesPointOutward) {
  // From far away, only fronts of closed solids can be seen.
  for (const char* name : {"table", "house", "relief", "hazards", "bench"}) {
    const SyntheticScene scene({.name = name, .shadows = false});
    for (int i = 0; i < 2000; ++i) {
      const double a = 0.7 * i, h = 0.15 + 0.8 * (i % 50) / 50.0;
      const Vector3d from(1.5 * std::cos(a), 1.5 * std::sin(a), 1.5 * h);
      const Vector3d to(0.2 * std::sin(3.1 * i), 0.15 * std::sin(1.7 * i), 0.05);
      SyntheticScene::Hit hit;
      if (!scene.Intersect(from, to - from, &hit)) continue;
      const auto& material = scene.materials()[scene.MaterialOf(hit.face)];
      if (material.name == "vase") continue;  // open at the top
      EXPECT_LT(scene.FaceNormal(hit.face).cast<double>().dot(to - from), 0)
          << name << ": " << material.name;
    }
  }
}

TEST(Scene, ShadowsAreDarkerThanTheOpenTable) {
  const auto brightness = [](double x, double y) {
    SyntheticScene::Hit hit;
    EXPECT_TRUE(StillLife().Intersect({x, y, 1.0}, {0, 0, -1}, &hit));
    double sum = 0;
    // The mean over a patch, because the texture varies.
    for (int i = 0; i < 400; ++i) {
      const double dx = 0.0004 * (i % 20 - 10), dy = 0.0004 * (i / 20 - 10);
      if (StillLife().Intersect({x + dx, y + dy, 1.0}, {0, 0, -1}, &hit)) {
        sum += StillLife().Radiance(hit, -Vector3f::UnitZ(), 0.001f).mean();
      }
    }
    return sum;
  };
  // The lamp is at -x, -y: the shadow of the cylinder at (-118, -62) mm falls towards +x, +y.
  EXPECT_LT(brightness(-0.085, -0.03), 0.75 * brightness(0.0, -0.075));
}

TEST(Scene, FinerPixelsShowFinerTexture) {
  const auto roughness = [](float footprint) {
    SyntheticScene::Hit hit;
    double sum = 0, last = 0;
    for (int i = 0; i < 1000; ++i) {
      EXPECT_TRUE(StillLife().Intersect({-0.3 + 1e-4 * i, -0.3, 1.0}, {0, 0, -1}, &hit));
      const double value = StillLife().Radiance(hit, -Vector3f::UnitZ(), footprint).mean();
      if (i > 0) sum += std::abs(value - last);
      last = value;
    }
    return sum;
  };
  EXPECT_GT(roughness(2e-4f), 2 * roughness(5e-3f));
}

TEST(Scene, OnlyGlossyThingsLookDifferentFromEverySide) {
  const SyntheticScene scene({.name = "hazards", .shadows = false});
  // The top of the glossy ball and the plain card, each seen from two sides.
  const auto change = [&](const Vector3d& place) {
    std::array<Vector3f, 2> light;
    for (int side = 0; side < 2; ++side) {
      const Vector3d from = place + (side ? Vector3d(0.1, -0.1, 0.45) : Vector3d(-0.4, -0.2, 0.12));
      SyntheticScene::Hit hit;
      EXPECT_TRUE(scene.Intersect(from, place - from, &hit));
      EXPECT_NEAR(hit.distance, 1, 0.01);
      const Vector3f direction = (place - from).normalized().cast<float>();
      // The pixel is wide: the places differ by a part of it.
      light[side] = scene.Radiance(hit, direction, 0.05f);
      const Vector3f diffuse = scene.DiffuseRadiance(hit, 0.05f);
      const auto& material = scene.materials()[scene.MaterialOf(hit.face)];
      EXPECT_EQ(light[side] == diffuse, material.gloss == 0) << material.name;
    }
    return (light[0] - light[1]).norm();
  };
  EXPECT_GT(change({0.0, -0.035, 0.072}), 0.01);
  EXPECT_LT(change({-0.15, -0.095, 0.001}), 1e-6);
}

TEST(Scene, APolishedTopMirrorsTheSky) {
  const SyntheticScene scene({.name = "hazards", .shadows = false});
  SyntheticScene::Hit hit;
  ASSERT_TRUE(scene.Intersect({0.092, 0.01, 1.0}, {0, 0, -1}, &hit));
  ASSERT_EQ(scene.materials()[scene.MaterialOf(hit.face)].name, "polished cylinder");
  const Vector3f sky = scene.Background({0, 0, 1});
  const Vector3f top = scene.Radiance(hit, {0, 0, -1}, 0.001f);
  const Vector3f own = scene.DiffuseRadiance(hit, 0.001f);
  // Head-on, Fresnel's share is the gloss.
  EXPECT_LT((top - (0.35f * own + 0.65f * sky)).norm(), 0.02f);
}

TEST(Scene, MeshMatchesTheRays) {
  const TriangleMesh mesh = StillLife().mesh();
  ASSERT_EQ(mesh.colors.size(), mesh.vertices.size());
  for (const auto& face : mesh.faces) {
    ASSERT_GE(face.minCoeff(), 0);
    ASSERT_LT(face.maxCoeff(), static_cast<int>(mesh.vertices.size()));
  }
  SyntheticScene::Hit hit;
  const Vector3d from(0.3, -0.4, 0.5), direction(-0.25, 0.45, -0.45);
  ASSERT_TRUE(StillLife().Intersect(from, direction, &hit));
  const auto corner = [&](int k) {
    return Vector3d(mesh.vertices[mesh.faces[hit.face][k]].cast<double>());
  };
  const Vector3d there = (1 - hit.u - hit.v) * corner(0) + hit.u * corner(1) + hit.v * corner(2);
  EXPECT_LT((from + hit.distance * direction - there).norm(), 1e-6);
}

TEST(Scene, SeedChangesTheTextureAndNotTheShape) {
  const TriangleMesh a = SyntheticScene({.name = "table", .shadows = false}).mesh();
  const TriangleMesh b = SyntheticScene({.name = "table", .seed = 2, .shadows = false}).mesh();
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_NE(a.colors, b.colors);
  EXPECT_EQ(a.colors, SyntheticScene({.name = "table", .shadows = false}).mesh().colors);
}

TEST(Scene, HasHardMaterialsAndObjectsInItsBox) {
  bool textureless = false, repetitive = false;
  for (const auto& material : StillLife().materials()) {
    textureless |= material.textureless;
    repetitive |= material.repetitive;
  }
  EXPECT_TRUE(textureless);
  EXPECT_TRUE(repetitive);
  SyntheticScene::Hit hit;
  ASSERT_TRUE(StillLife().Intersect({0.02, 0.082, 1}, {0.01, 0, -1}, &hit));
  EXPECT_TRUE(
      StillLife().box().Contains(Vector3d(0.02, 0.082, 1) + hit.distance * Vector3d(0.01, 0, -1)));
}

TEST(Scene, UnknownNameIsRejected) {
  EXPECT_THROW(SyntheticScene({.name = "castle"}), std::invalid_argument);
}

TEST(Noise, IsCenteredBoundedAndContinuous) {
  double sum = 0, squares = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const Vector3f p(0.137f * static_cast<float>(i % 177),
                     0.211f * static_cast<float>(i / 177),
                     0.0931f * static_cast<float>(i % 89));
    const float value = synth::GradientNoise(p);
    ASSERT_LE(std::abs(value), 1.05f);
    EXPECT_NEAR(synth::GradientNoise(p + Vector3f::Constant(1e-4f)), value, 1e-3f);
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.02);
  EXPECT_NEAR(std::sqrt(squares / kCount), 0.27, 0.05);
}

}  // namespace
}  // namespace livemvs
