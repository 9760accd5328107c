#include "livemvs/pipeline/spawner.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <set>

#include "livemvs/pipeline/pyramid.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::TestOptions;

SceneRange NearFar() {
  SceneRange range;
  range.near = 0.5;
  range.far = 2;
  return range;
}

SeedPool PoolOf(std::size_t slots) {
  Options options;
  options.max_seeds = static_cast<int>(slots);
  return SeedPool(MakeCpuBackend(options));
}

std::vector<SeedState> SeedsOf(const SeedPool& pool) {
  std::vector<SeedState> seeds;
  pool.ForEachAlive(1, [&](const ReferenceFrame&, const SeedState& s) { seeds.push_back(s); });
  return seeds;
}

class SpawnerTest : public ::testing::Test {
 protected:
  std::int64_t Spawn(Spawner&& spawner, const PointCloud& points, SeedPool* pool) const {
    return Spawn(spawner, points, pool);
  }
  std::int64_t Spawn(Spawner& spawner, const PointCloud& points, SeedPool* pool) const {
    Pyramid pyramid;
    pyramid.Build(frame_.picture->grey, options_.levels);
    return spawner.Spawn(frame_, pyramid.levels(), points, pool);
  }

  // Pixels of the pool's seeds in their own frame.
  std::vector<Eigen::Vector2i> Pixels(const SeedPool& pool) const {
    std::vector<Eigen::Vector2i> pixels;
    for (const SeedState& s : SeedsOf(pool)) {
      const auto p = Projector(frame_.camera).Project({s.bearing_x, s.bearing_y, 1});
      pixels.emplace_back(std::lround(p->x()), std::lround(p->y()));
    }
    return pixels;
  }

  PlaneScene scene_;
  PosedFrame frame_ = scene_.Render(Rigid3d{}, 4);
  Options options_ = TestOptions();
};

TEST_F(SpawnerTest, PlantsThePriorOfSection42) {
  SeedPool pool = PoolOf(4000);
  const auto planted = Spawn(Spawner(options_, NearFar()), {}, &pool);
  ASSERT_GT(planted, 1000);
  EXPECT_EQ(static_cast<std::size_t>(planted), pool.size());
  ASSERT_EQ(pool.references().size(), 1U);
  EXPECT_EQ(pool.references()[0].frame_index, 4);
  for (const SeedState& s : SeedsOf(pool)) {
    ASSERT_EQ(s.posterior.mu, 0.5F);
    // 99 % of the mass in [0, 1].
    ASSERT_NEAR(std::erf(0.5 / std::sqrt(2.0 * s.posterior.sigma2)), 0.99, 1e-4);
    ASSERT_EQ(s.posterior.a, options_.prior_a);
    ASSERT_EQ(s.posterior.b, options_.prior_b);
    const double norm = std::sqrt(1 + std::pow(s.bearing_x, 2) + std::pow(s.bearing_y, 2));
    ASSERT_NEAR(1 / s.interval.c0, 0.5 * norm, 1e-6);
    ASSERT_NEAR(1 / s.interval.c1, 2 * norm, 1e-6);
  }
  const std::vector<std::uint8_t> patches = pool.Patches(pool.references()[0]);
  const auto pixels = Pixels(pool);
  for (std::size_t i = 0; i < pool.size(); i += 37) {
    for (int k = 0; k < kPatchPixels; ++k) {
      ASSERT_EQ(patches[i * kPatchPixels + k],
                frame_.picture->grey(pixels[i].x() + k % kPatchSize - kPatchRadius,
                                     pixels[i].y() + k / kPatchSize - kPatchRadius));
    }
  }
}

TEST_F(SpawnerTest, IntervalsEndAtTheBox) {
  SceneRange range;
  range.near = 0.2;
  range.far = 5;
  range.box = Box{{-0.2, -0.15, 0.8}, {0.25, 0.2, 1.3}};
  options_.coordinate = DepthCoordinate::kDepth;
  SeedPool pool = PoolOf(4000);
  ASSERT_GT(Spawn(Spawner(options_, range), {}, &pool), 300);
  constexpr double kTolerance = 1e-5;
  const auto on_surface = [&](const Eigen::Vector3d& p) {
    const Box box = *range.SoughtBox();
    const double inside =
        std::min((p - box.min).minCoeff(), (box.max - p).minCoeff());  // 0 on the surface
    return std::abs(inside) < kTolerance;
  };
  for (const SeedState& s : SeedsOf(pool)) {
    const Eigen::Vector3d bearing = Eigen::Vector3d(s.bearing_x, s.bearing_y, 1).normalized();
    const auto [c0, c1] = s.interval;
    ASSERT_TRUE(on_surface(bearing * c0)) << (bearing * c0).transpose();
    ASSERT_TRUE(on_surface(bearing * c1)) << (bearing * c1).transpose();
    ASSERT_LT(c0, c1);
  }
}

TEST_F(SpawnerTest, LiveSeedsKeepTheirPixels) {
  SeedPool pool = PoolOf(20'000);
  Spawner spawner(options_, NearFar());
  ASSERT_GT(Spawn(spawner, {}, &pool), 1000);
  EXPECT_EQ(Spawn(spawner, {}, &pool), 0) << "every pixel has its seed already";
  options_.cover_radius_px = -1;
  EXPECT_GT(Spawn(Spawner(options_, NearFar()), {}, &pool), 1000) << "as published";
}

TEST_F(SpawnerTest, PointsCoverOnlyTheSideTheyWereSeenFrom) {
  // Points over the left half of the picture, at depth 1.
  PointCloud points;
  for (int y = 0; y < frame_.camera.height; ++y) {
    for (int x = 0; x < 100; ++x) {
      Point p;
      p.position = Projector(frame_.camera).Unproject({x, y})->cast<float>();
      p.normal = -p.position.normalized();
      points.push_back(p);
    }
  }
  SeedPool pool = PoolOf(4000);
  Spawn(Spawner(options_, NearFar()), points, &pool);
  ASSERT_GT(pool.size(), 300U);
  for (const auto& pixel : Pixels(pool)) EXPECT_GT(pixel.x(), 100);
  // The same points, seen from behind.
  for (Point& p : points) p.normal = -p.normal;
  SeedPool all = PoolOf(4000);
  Spawn(Spawner(options_, NearFar()), points, &all);
  int left = 0;
  for (const auto& pixel : Pixels(all)) left += pixel.x() < 100;
  EXPECT_GT(left, 300);
}

TEST_F(SpawnerTest, ThinsEvenly) {
  options_.seed_spacing_px = 1;
  options_.min_patch_stddev = 0;
  for (const std::size_t slots : {150U, 1000U, 7000U}) {
    SeedPool pool = PoolOf(slots);
    EXPECT_EQ(Spawn(Spawner(options_, NearFar()), {}, &pool), static_cast<std::int64_t>(slots));
    // The picture in 5 x 5 parts: each has its share, give or take a third and a few.
    int count[25] = {};
    for (const auto& p : Pixels(pool)) ++count[p.y() * 5 / 150 * 5 + p.x() * 5 / 200];
    const double share = static_cast<double>(slots) / 25;
    for (const int c : count) EXPECT_NEAR(c, share, share / 3 + 4) << slots;
  }
}

TEST_F(SpawnerTest, NoSeedsWhereNothingCanMatch) {
  scene_.plain_left = 0;  // the left half of the plane has noise only
  scene_.noise = 1;
  frame_ = scene_.Render(Rigid3d{}, 0);
  SeedPool pool = PoolOf(4000);
  ASSERT_GT(Spawn(Spawner(options_, NearFar()), {}, &pool), 300);
  for (const auto& pixel : Pixels(pool)) EXPECT_GT(pixel.x(), frame_.camera.cx - 3);
}

TEST_F(SpawnerTest, WhatRefusedPixelsLeaveGoesToOthers) {
  // Mostly ramps, which have contrast but cannot be matched; texture in a strip on the right.
  std::mt19937 random(5);
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(frame_.camera.width, frame_.camera.height);
  const int strip = frame_.camera.width - 30;
  for (int y = 0; y < frame_.camera.height; ++y) {
    for (int x = 0; x < frame_.camera.width; ++x) {
      const auto grey = x < strip ? static_cast<unsigned>(10 * x) % 250U : random() % 256U;
      picture->grey(x, y) = static_cast<std::uint8_t>(grey);
    }
  }
  frame_.picture = picture;
  options_.levels = 1;
  options_.min_patch_stddev = 10;
  constexpr std::size_t kSlots = 500;
  SeedPool pool = PoolOf(kSlots);
  EXPECT_EQ(Spawn(Spawner(options_, NearFar()), {}, &pool), static_cast<std::int64_t>(kSlots));
}

TEST_F(SpawnerTest, TinyPicturesAndMissedBoxesGiveNoSeeds) {
  SeedPool pool = PoolOf(100);
  SceneRange behind;
  behind.near = 0.1;
  behind.far = 10;
  behind.box = Box{{-1, -1, -3}, {1, 1, -2}};
  EXPECT_EQ(Spawn(Spawner(options_, behind), {}, &pool), 0);
  scene_.camera.width = 4;
  scene_.camera.height = 3;
  frame_ = scene_.Render(Rigid3d{}, 0);
  EXPECT_EQ(Spawn(Spawner(options_, NearFar()), {}, &pool), 0);
}

TEST_F(SpawnerTest, EachLevelHasItsOwnGroupPatchesAndCoverage) {
  options_.levels = 2;
  options_.min_coarse_stddev = 5;
  SeedPool pool = PoolOf(20'000);
  ASSERT_GT(Spawn(Spawner(options_, NearFar()), {}, &pool), 1000);
  ASSERT_EQ(pool.references().size(), 2U);
  const ReferenceFrame& coarse = pool.references()[0];
  EXPECT_EQ(coarse.level, 1);
  EXPECT_EQ(pool.references()[1].level, 0);
  EXPECT_EQ(coarse.camera.width, frame_.camera.width / 2);
  Pyramid pyramid;
  pyramid.Build(frame_.picture->grey, 2);
  const Projector projector(coarse.camera);
  const std::vector<SeedState> seeds = SeedsOf(pool);
  const std::vector<std::uint8_t> patches = pool.Patches(coarse);
  ASSERT_EQ(coarse.begin, 0U);
  for (std::size_t i = 0; i < coarse.end; ++i) {
    const auto p = projector.Project({seeds[i].bearing_x, seeds[i].bearing_y, 1});
    const auto x = static_cast<int>(std::lround(p->x())), y = static_cast<int>(std::lround(p->y()));
    ASSERT_EQ(patches[i * kPatchPixels + kPatchPixels / 2], pyramid.levels()[1](x, y));
  }
  // A point as wide as a pixel of level 1 covers that level, but not the finer one.
  PointCloud points;
  for (int y = 0; y < frame_.camera.height; ++y) {
    for (int x = 0; x < frame_.camera.width; ++x) {
      Point p;
      p.position = Projector(frame_.camera).Unproject({x, y})->cast<float>();
      p.normal = -p.position.normalized();
      p.footprint = p.position.norm() * 2 / static_cast<float>(frame_.camera.FocalLength());
      points.push_back(p);
    }
  }
  SeedPool fine = PoolOf(20'000);
  Spawn(Spawner(options_, NearFar()), points, &fine);
  ASSERT_EQ(fine.references().size(), 1U);
  EXPECT_EQ(fine.references()[0].level, 0);
  for (Point& p : points) p.footprint /= 2;
  SeedPool none = PoolOf(20'000);
  EXPECT_EQ(Spawn(Spawner(options_, NearFar()), points, &none), 0);
}

}  // namespace
}  // namespace livemvs
