// What planting is for, on every backend; planting_bits_test.cc compares it seed by seed.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/backend_test_util.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::Shrunk;
using testing_support::TestOptions;

SceneRange NearFar() {
  SceneRange range;
  range.near = 0.5;
  range.far = 2;
  return range;
}

class PlantingTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const std::string trouble = testing_support::TroubleWith(GetParam());
    if (!trouble.empty()) GTEST_SKIP() << trouble;
  }

  std::unique_ptr<Backend> BackendOf(std::size_t slots) const {
    Options options = options_;
    options.max_seeds = static_cast<int>(slots);
    return testing_support::MakeBackendOf(GetParam(), options);
  }

  // Plants in the frame, and returns how many seeds on each level.
  std::vector<std::size_t> Plant(const SceneRange& range,
                                 const PointCloud& points,
                                 Backend* backend,
                                 const std::vector<SeedGroup>& groups = {}) const {
    const Image<std::uint8_t> half = Shrunk(frame_.picture->grey, 2);
    std::vector<ImageView<std::uint8_t>> pyramid = {frame_.picture->grey.view()};
    if (options_.levels > 1) pyramid.push_back(half.view());
    backend->SetFrame(pyramid);
    return backend->Plant({{frame_.camera, frame_.cam_from_world}, &range, groups, points});
  }

  // The same, of one level.
  std::size_t PlantOn(const SceneRange& range, const PointCloud& points, Backend* backend) const {
    return Plant(range, points, backend)[0];
  }

  // Pixels of the first seeds in their own frame.
  std::vector<Eigen::Vector2i> Pixels(std::size_t seeds, Backend* backend) const {
    std::vector<Eigen::Vector2i> pixels;
    for (const SeedState& s : backend->Read(0, seeds, 1)) {
      const auto p = Projector(frame_.camera).Project({s.bearing_x, s.bearing_y, 1});
      pixels.emplace_back(std::lround(p->x()), std::lround(p->y()));
    }
    return pixels;
  }

  // A point at depth 1 on each pixel left of column `end`, as wide as `pixels` pixels.
  PointCloud PointsLeftOf(int end, float pixels) const {
    PointCloud points;
    const Projector projector(frame_.camera);
    for (int y = 0; y < frame_.camera.height; ++y) {
      for (int x = 0; x < end; ++x) {
        Point p;
        p.position = projector.Unproject({x, y})->cast<float>();
        p.normal = -p.position.normalized();
        p.footprint = p.position.norm() * pixels / static_cast<float>(frame_.camera.FocalLength());
        points.push_back(p);
      }
    }
    return points;
  }

  PlaneScene scene_;
  PosedFrame frame_ = scene_.Render(Rigid3d{}, 4);
  Options options_ = TestOptions();
};

TEST_P(PlantingTest, PlantsThePriorOfSection42) {
  const auto backend = BackendOf(4000);
  const std::size_t planted = PlantOn(NearFar(), {}, backend.get());
  ASSERT_GT(planted, 1000U);
  for (const SeedState& s : backend->Read(0, planted, 1)) {
    ASSERT_EQ(s.posterior.mu, 0.5F);
    // 99 % of the mass in [0, 1].
    ASSERT_NEAR(std::erf(0.5 / std::sqrt(2.0 * s.posterior.sigma2)), 0.99, 1e-4);
    ASSERT_EQ(s.posterior.a, options_.prior_a);
    ASSERT_EQ(s.posterior.b, options_.prior_b);
    const double norm = std::sqrt(1 + std::pow(s.bearing_x, 2) + std::pow(s.bearing_y, 2));
    ASSERT_NEAR(1 / s.interval.c0, 0.5 * norm, 1e-6);
    ASSERT_NEAR(1 / s.interval.c1, 2 * norm, 1e-6);
  }
  const std::vector<std::uint8_t> patches = backend->ReadPatches(0, planted);
  const auto pixels = Pixels(planted, backend.get());
  for (std::size_t i = 0; i < planted; i += 37) {
    for (int k = 0; k < kPatchPixels; ++k) {
      ASSERT_EQ(patches[i * kPatchPixels + k],
                frame_.picture->grey(pixels[i].x() + k % kPatchSize - kPatchRadius,
                                     pixels[i].y() + k / kPatchSize - kPatchRadius));
    }
  }
}

TEST_P(PlantingTest, IntervalsEndAtTheBox) {
  SceneRange range;
  range.near = 0.2;
  range.far = 5;
  range.box = Box{{-0.2, -0.15, 0.8}, {0.25, 0.2, 1.3}};
  range.margin = 0.02;
  options_.coordinate = DepthCoordinate::kDepth;
  const auto backend = BackendOf(4000);
  const std::size_t planted = PlantOn(range, {}, backend.get());
  ASSERT_GT(planted, 300U);
  constexpr double kTolerance = 1e-5;
  const auto on_surface = [&](const Eigen::Vector3d& p) {
    const Box box = *range.SoughtBox();
    const double inside =
        std::min((p - box.min).minCoeff(), (box.max - p).minCoeff());  // 0 on the surface
    return std::abs(inside) < kTolerance;
  };
  for (const SeedState& s : backend->Read(0, planted, 1)) {
    const Eigen::Vector3d bearing = Eigen::Vector3d(s.bearing_x, s.bearing_y, 1).normalized();
    const auto [c0, c1] = s.interval;
    ASSERT_TRUE(on_surface(bearing * c0)) << (bearing * c0).transpose();
    ASSERT_TRUE(on_surface(bearing * c1)) << (bearing * c1).transpose();
    ASSERT_LT(c0, c1);
  }
}

TEST_P(PlantingTest, LiveSeedsKeepTheirPixels) {
  auto backend = BackendOf(20'000);
  const std::size_t planted = PlantOn(NearFar(), {}, backend.get());
  ASSERT_GT(planted, 1000U);
  const RelativeView<float> view = MakeRelativeView<float>(
      frame_.camera, frame_.cam_from_world, frame_.camera, frame_.cam_from_world);
  const SeedGroup group = {0, planted, 0, view, 0.01F};
  EXPECT_EQ(Plant(NearFar(), {}, backend.get(), {group})[0], 0U)
      << "every pixel has its seed already";
  options_.cover_radius_px = -1;
  backend = BackendOf(20'000);
  PlantOn(NearFar(), {}, backend.get());
  EXPECT_GT(Plant(NearFar(), {}, backend.get(), {group})[0], 1000U) << "as published";
}

TEST_P(PlantingTest, PointsCoverOnlyTheSideTheyWereSeenFrom) {
  PointCloud points = PointsLeftOf(100, 0);
  const auto backend = BackendOf(4000);
  const std::size_t right = PlantOn(NearFar(), points, backend.get());
  ASSERT_GT(right, 300U);
  for (const auto& pixel : Pixels(right, backend.get())) EXPECT_GT(pixel.x(), 100);
  // The same points, seen from behind.
  for (Point& p : points) p.normal = -p.normal;
  const auto all = BackendOf(4000);
  const std::size_t planted = PlantOn(NearFar(), points, all.get());
  int left = 0;
  for (const auto& pixel : Pixels(planted, all.get())) left += pixel.x() < 100;
  EXPECT_GT(left, 300);
}

TEST_P(PlantingTest, NewPointsAreAddedToThoseKnown) {
  const auto backend = BackendOf(20'000);
  const PointCloud points = PointsLeftOf(150, 0);
  const auto some = [&](std::size_t n) { return PointCloud(points.begin(), points.begin() + n); };
  const auto end = static_cast<std::ptrdiff_t>(points.size() / 2);
  const std::size_t first = PlantOn(NearFar(), some(end), backend.get());
  ASSERT_GT(first, 1000U);
  const std::size_t second = PlantOn(NearFar(), points, backend.get());
  EXPECT_LT(second, first) << "the lower half is covered, too";
  ASSERT_GT(second, 100U);
  // Others in their place.
  backend->ForgetPoints();
  EXPECT_EQ(PlantOn(NearFar(), some(end), backend.get()), first);
}

TEST_P(PlantingTest, TheLastOfManyPointsCoverToo) {
  // More than travel to a device at once; those before the last face away.
  PointCloud points;
  PointCloud away = PointsLeftOf(frame_.camera.width, 0);
  for (Point& p : away) p.normal = -p.normal;
  while (points.size() < 140'000) points.insert(points.end(), away.begin(), away.end());
  const PointCloud left = PointsLeftOf(100, 0);
  points.insert(points.end(), left.begin(), left.end());
  const auto backend = BackendOf(20'000);
  const std::size_t planted = PlantOn(NearFar(), points, backend.get());
  EXPECT_EQ(planted, PlantOn(NearFar(), left, BackendOf(20'000).get()));
  ASSERT_GT(planted, 300U);
  for (const auto& pixel : Pixels(planted, backend.get())) EXPECT_GT(pixel.x(), 100);
}

TEST_P(PlantingTest, PicturesMayGrow) {
  const auto backend = BackendOf(40'000);
  const PosedFrame large = frame_;
  scene_.camera.width /= 2;
  scene_.camera.height /= 2;
  frame_ = scene_.Render(Rigid3d{}, 4);
  const std::size_t few = PlantOn(NearFar(), {}, backend.get());
  ASSERT_GT(few, 100U);
  frame_ = large;
  const std::size_t many = PlantOn(NearFar(), {}, backend.get());
  EXPECT_GT(many, 2 * few);
  EXPECT_EQ(many, PlantOn(NearFar(), {}, BackendOf(40'000).get()));
}

TEST_P(PlantingTest, ThinsEvenly) {
  options_.seed_spacing_px = 1;
  options_.min_patch_stddev = 0;
  for (const std::size_t slots : {150U, 1000U, 7000U}) {
    const auto backend = BackendOf(slots);
    EXPECT_EQ(PlantOn(NearFar(), {}, backend.get()), slots);
    // The picture in 5 x 5 parts: each has its share, give or take a third and a few.
    int count[25] = {};
    for (const auto& p : Pixels(slots, backend.get()))
      ++count[p.y() * 5 / 150 * 5 + p.x() * 5 / 200];
    const double share = static_cast<double>(slots) / 25;
    for (const int c : count) EXPECT_NEAR(c, share, share / 3 + 4) << slots;
  }
}

TEST_P(PlantingTest, NoSeedsWhereNothingCanMatch) {
  scene_.plain_left = 0;  // the left half of the plane has noise only
  scene_.noise = 1;
  frame_ = scene_.Render(Rigid3d{}, 0);
  const auto backend = BackendOf(4000);
  const std::size_t planted = PlantOn(NearFar(), {}, backend.get());
  ASSERT_GT(planted, 300U);
  for (const auto& pixel : Pixels(planted, backend.get())) {
    EXPECT_GT(pixel.x(), frame_.camera.cx - 3);
  }
}

TEST_P(PlantingTest, WhatRefusedPixelsLeaveGoesToOthers) {
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
  EXPECT_EQ(PlantOn(NearFar(), {}, BackendOf(kSlots).get()), kSlots);
}

TEST_P(PlantingTest, TinyPicturesAndMissedBoxesGiveNoSeeds) {
  const auto backend = BackendOf(100);
  SceneRange behind;
  behind.near = 0.1;
  behind.far = 10;
  behind.box = Box{{-1, -1, -3}, {1, 1, -2}};
  EXPECT_EQ(PlantOn(behind, {}, backend.get()), 0U);
  scene_.camera.width = 4;
  scene_.camera.height = 3;
  frame_ = scene_.Render(Rigid3d{}, 0);
  EXPECT_EQ(PlantOn(NearFar(), {}, backend.get()), 0U);
}

TEST_P(PlantingTest, EachLevelHasItsOwnPatchesAndCoverage) {
  options_.levels = 2;
  options_.min_coarse_stddev = 5;
  const auto backend = BackendOf(20'000);
  const std::vector<std::size_t> planted = Plant(NearFar(), {}, backend.get());
  ASSERT_EQ(planted.size(), 2U);
  ASSERT_GT(planted[1], 300U);
  ASSERT_GT(planted[0], 1000U);
  const Projector projector(AtLevel(frame_.camera, 1));
  const Image<std::uint8_t> half = Shrunk(frame_.picture->grey, 2);
  const std::vector<SeedState> seeds = backend->Read(0, planted[1], 1);
  const std::vector<std::uint8_t> patches = backend->ReadPatches(0, planted[1]);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const auto p = projector.Project({seeds[i].bearing_x, seeds[i].bearing_y, 1});
    const auto x = static_cast<int>(std::lround(p->x())), y = static_cast<int>(std::lround(p->y()));
    ASSERT_EQ(patches[i * kPatchPixels + kPatchPixels / 2], half(x, y));
  }
  // Points as wide as a pixel of level 1 cover that level, but not the finer one.
  const std::vector<std::size_t> fine =
      Plant(NearFar(), PointsLeftOf(frame_.camera.width, 2), BackendOf(20'000).get());
  EXPECT_EQ(fine[1], 0U);
  EXPECT_GT(fine[0], 1000U);
  const std::vector<std::size_t> none =
      Plant(NearFar(), PointsLeftOf(frame_.camera.width, 1), BackendOf(20'000).get());
  EXPECT_EQ(none, (std::vector<std::size_t>{0, 0}));
}

INSTANTIATE_TEST_SUITE_P(All,
                         PlantingTest,
                         ::testing::ValuesIn(testing_support::BackendKinds()),
                         [](const ::testing::TestParamInfo<std::string>& tested) {
                           return testing_support::TestNameOf(tested.param);
                         });

}  // namespace
}  // namespace livemvs
