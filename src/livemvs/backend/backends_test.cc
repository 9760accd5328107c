// What every backend must do, and that all give the same: those of the CPU, and the GPU's where
// there is one.

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/backend_test_util.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::BackendKinds;
using testing_support::kCuda;
using testing_support::MakeBackendOf;
using testing_support::PlaneScene;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

bool SameNumbers(const SeedState& a, const SeedState& b) {
  return a.posterior.mu == b.posterior.mu && a.posterior.sigma2 == b.posterior.sigma2 &&
         a.posterior.a == b.posterior.a && a.posterior.b == b.posterior.b;
}

bool SameCounts(const SeedState& a, const SeedState& b) {
  return a.counts.age == b.counts.age && a.counts.views == b.counts.views &&
         a.counts.unseen == b.counts.unseen && a.fate == b.fate;
}

// Plants a seed in a frame wherever the options let it, and returns how many.
std::size_t PlantAll(const PosedFrame& frame, Backend* backend) {
  SceneRange range;
  range.near = 0.7;
  range.far = 1.6;
  const ImageView<std::uint8_t> pyramid[] = {frame.picture->grey.view()};
  backend->SetFrame(pyramid);
  return backend->Plant({{frame.camera, frame.cam_from_world}, &range, {}, {}})[0];
}

SeedGroup GroupOf(const PosedFrame& ref,
                  const PosedFrame& cur,
                  std::size_t begin,
                  std::size_t end) {
  return {begin,
          end,
          0,
          MakeRelativeView<float>(ref.camera, ref.cam_from_world, cur.camera, cur.cam_from_world),
          static_cast<float>(1 / ref.camera.FocalLength())};
}

class BackendTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const std::string trouble = testing_support::TroubleWith(GetParam());
    if (!trouble.empty()) GTEST_SKIP() << trouble;
  }

  // A seed on every step-th pixel that can be matched at all, whatever is known there.
  static Options PlantingEvery(int step, const Options& options = TestOptions()) {
    Options planting = options;
    planting.max_seeds = 40'000;
    planting.seed_spacing_px = step;
    planting.min_patch_stddev = 0;
    planting.cover_radius_px = -1;
    return planting;
  }

  // A seed on every pixel, that ends with the first frame that tells it something.
  static Options EndingAtOnce() {
    Options ending = PlantingEvery(1);
    ending.max_age = 1;
    ending.min_views = 200;
    return ending;
  }

  static UpdateStatistics Update(const PosedFrame& cur,
                                 std::span<const SeedGroup> groups,
                                 Backend* backend) {
    const ImageView<std::uint8_t> pyramid[] = {cur.picture->grey.view()};
    backend->SetFrame(pyramid);
    return backend->Update(groups, cur.camera.model);
  }

  // All seeds, in two groups, of which the first does not end with a whole block.
  static UpdateStatistics Update(const PosedFrame& ref,
                                 const PosedFrame& cur,
                                 std::size_t seeds,
                                 Backend* backend) {
    const std::size_t middle = seeds / 3;
    const SeedGroup groups[] = {GroupOf(ref, cur, 0, middle), GroupOf(ref, cur, middle, seeds)};
    return Update(cur, groups, backend);
  }

  // Runs both backends over the frames, from the same seeds; the GPU's library rounds the arc
  // tangent of fisheye lenses in its own way, whence `tolerance`.
  static void ExpectSame(const std::vector<PosedFrame>& frames,
                         const Options& options,
                         double tolerance) {
    const std::unique_ptr<Backend> expected =
        MakeBackendOf("single lane", PlantingEvery(2, options));
    const std::unique_ptr<Backend> backend = MakeBackendOf(GetParam(), PlantingEvery(2, options));
    const std::size_t born = PlantAll(frames[0], expected.get());
    ASSERT_EQ(PlantAll(frames[0], backend.get()), born);
    std::int64_t matched = 0;
    for (std::size_t f = 1; f < frames.size(); ++f) {
      const UpdateStatistics a = Update(frames[0], frames[f], born, expected.get());
      const UpdateStatistics b = Update(frames[0], frames[f], born, backend.get());
      const auto share = tolerance > 0 ? static_cast<double>(born) / 500 : 0;
      EXPECT_NEAR(static_cast<double>(a.matched), static_cast<double>(b.matched), share);
      EXPECT_EQ(a.total(), b.total());
      matched += a.matched;
    }
    EXPECT_GT(matched, static_cast<std::int64_t>(born)) << "too little to compare";
    const std::vector<SeedState> want = expected->Read(0, born, 1);
    const std::vector<SeedState> have = backend->Read(0, born, 1);
    ASSERT_EQ(want.size(), have.size());
    std::size_t other_counts = 0, other_numbers = 0;
    for (std::size_t i = 0; i < want.size(); ++i) {
      other_counts += !SameCounts(want[i], have[i]);
      other_numbers += tolerance > 0
                           ? std::abs(want[i].posterior.mu - have[i].posterior.mu) > tolerance
                           : !SameNumbers(want[i], have[i]);
    }
    const std::size_t allowed = tolerance > 0 ? born / 500 : 0;
    EXPECT_LE(other_counts, allowed);
    EXPECT_LE(other_numbers, allowed);
  }
};

TEST_P(BackendTest, UpdatesAsTheOthersDo) {
  for (const auto search : {Search::kWindow, Search::kFull}) {
    Options options = TestOptions();
    options.search = search;
    ExpectSame(PlaneScene().Render(SidewaysPath(6)), options, 0);
  }
}

TEST_P(BackendTest, FollowsTurnsAndScalesAsTheOthersDo) {
  std::vector<Rigid3d> turning = SidewaysPath(6), nearing = SidewaysPath(6);
  for (std::size_t i = 0; i < turning.size(); ++i) {
    const auto n = static_cast<double>(i);
    const Eigen::Matrix3d roll =
        Eigen::AngleAxisd(0.08 * n, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    turning[i] = Rigid3d{roll, {0, 0, 0}} * turning[i];
    nearing[i] = Rigid3d{Eigen::Matrix3d::Identity(), {0, 0, -0.05 * n}} * nearing[i];
  }
  ExpectSame(PlaneScene().Render(turning), TestOptions(), 0);
  ExpectSame(PlaneScene().Render(nearing), TestOptions(), 0);
}

TEST_P(BackendTest, SeesThroughLensesAsTheOthersDo) {
  for (const auto model : {CameraModel::kBrownConrady, CameraModel::kKannalaBrandt}) {
    PlaneScene scene;
    scene.camera.model = model;
    scene.camera.distortion = {-0.02, 0.006, -0.003, 4e-4};
    const bool rounds_otherwise = model == CameraModel::kKannalaBrandt && GetParam() == kCuda;
    ExpectSame(scene.Render(SidewaysPath(6)), TestOptions(), rounds_otherwise ? 1e-4 : 0);
  }
}

TEST_P(BackendTest, CountsEveryLivingSeedOnce) {
  const auto frames = PlaneScene().Render(SidewaysPath(3));
  const Options options = EndingAtOnce();
  const std::unique_ptr<Backend> backend = MakeBackendOf(GetParam(), options);
  const std::size_t born = PlantAll(frames[0], backend.get());
  EXPECT_EQ(Update(frames[0], frames[1], born, backend.get()).total(),
            static_cast<std::int64_t>(born));
  const auto ended = static_cast<std::int64_t>(backend->TakeEnded().size());
  EXPECT_GT(ended, static_cast<std::int64_t>(born) / 2);
  EXPECT_EQ(Update(frames[0], frames[2], born, backend.get()).total(),
            static_cast<std::int64_t>(born) - ended);
}

TEST_P(BackendTest, SeedsOfNoGroupStayAsTheyAre) {
  const auto frames = PlaneScene().Render(SidewaysPath(3));
  const Options options = EndingAtOnce();
  const std::unique_ptr<Backend> backend = MakeBackendOf(GetParam(), options);
  const std::size_t born = PlantAll(frames[0], backend.get());
  const std::size_t first = born / 4, last = born / 2 + 3;
  const std::vector<SeedState> before = backend->Read(0, born, 1);
  EXPECT_EQ(Update(frames[1], {}, backend.get()).total(), 0);
  EXPECT_TRUE(backend->TakeEnded().empty());

  const SeedGroup some[] = {GroupOf(frames[0], frames[1], first, last)};
  EXPECT_EQ(Update(frames[1], some, backend.get()).total(),
            static_cast<std::int64_t>(last - first));
  const std::vector<SeedState> after = backend->Read(0, born, 1);
  std::size_t other = 0;
  for (std::size_t i = 0; i < born; ++i) {
    const bool same = SameNumbers(before[i], after[i]) && SameCounts(before[i], after[i]);
    other += !same;
    ASSERT_TRUE(same || (i >= first && i < last)) << i;
  }
  EXPECT_GT(other, (last - first) / 2);

  // Nobody took those that ended; a frame without groups does not lose them.
  EXPECT_EQ(Update(frames[2], {}, backend.get()).total(), 0);
  const std::size_t ended = backend->TakeEnded().size();
  EXPECT_GT(ended, (last - first) / 2);
  backend->Compact();
  const SeedGroup rest[] = {GroupOf(frames[0], frames[2], 0, born - ended)};
  EXPECT_EQ(Update(frames[2], rest, backend.get()).total(),
            static_cast<std::int64_t>(born - ended));
}

TEST_P(BackendTest, GivesEachEndedSeedOnceAndClosesGapsInOrder) {
  const auto frames = PlaneScene().Render(SidewaysPath(2));
  Options options = EndingAtOnce();
  options.max_seeds = 20'000;  // fewer than would fit the picture
  const std::unique_ptr<Backend> backend = MakeBackendOf(GetParam(), options);
  const std::size_t born = PlantAll(frames[0], backend.get());
  Update(frames[0], frames[1], born, backend.get());
  const std::vector<SeedState> before = backend->Read(0, born, 1);
  const std::vector<std::uint8_t> patches = backend->ReadPatches(0, born);
  const auto span = backend->TakeEnded();
  const std::vector<EndedSeed> ended(span.begin(), span.end());
  ASSERT_FALSE(ended.empty());
  ASSERT_LT(ended.size(), born);
  EXPECT_TRUE(std::ranges::is_sorted(ended, {}, &EndedSeed::slot));
  std::set<std::size_t> gone;
  for (const EndedSeed& e : ended) {
    EXPECT_TRUE(SameNumbers(e.seed, before[e.slot]) && SameCounts(e.seed, before[e.slot]));
    EXPECT_NE(e.seed.fate, Fate::kAlive);
    const std::uint8_t* patch = patches.data() + std::size_t{e.slot} * kPatchPixels;
    EXPECT_TRUE(std::equal(patch, patch + kPatchPixels, std::begin(e.patch))) << e.slot;
    EXPECT_TRUE(gone.insert(e.slot).second);
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].fate != Fate::kAlive, gone.contains(i)) << i;
  }
  EXPECT_TRUE(backend->TakeEnded().empty());
  ASSERT_EQ(born, backend->capacity());
  EXPECT_EQ(PlantAll(frames[1], backend.get()), 0U) << "the gaps are not closed yet";

  backend->Compact();
  std::vector<SeedState> kept;
  std::vector<std::uint8_t> kept_patches;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (gone.contains(i)) continue;
    kept.push_back(before[i]);
    const auto patch = patches.begin() + static_cast<std::ptrdiff_t>(i * kPatchPixels);
    kept_patches.insert(kept_patches.end(), patch, patch + kPatchPixels);
  }
  const std::vector<SeedState> after = backend->Read(0, kept.size(), 1);
  EXPECT_TRUE(std::ranges::equal(after, kept, SameNumbers));
  EXPECT_TRUE(std::ranges::equal(after, kept, SameCounts));
  EXPECT_EQ(backend->ReadPatches(0, kept.size()), kept_patches);

  // The slots that came free take others.
  ASSERT_EQ(PlantAll(frames[1], backend.get()), ended.size());
  const std::vector<SeedState> anew = backend->Read(kept.size(), born, 1);
  ASSERT_EQ(anew.size(), ended.size());
  for (const SeedState& seed : anew) {
    ASSERT_EQ(seed.counts.age, 0);
    ASSERT_EQ(seed.fate, Fate::kAlive);
  }
  EXPECT_TRUE(std::ranges::equal(backend->Read(0, kept.size(), 1), kept, SameNumbers));
}

TEST_P(BackendTest, ResultsDoNotDependOnTheThreads) {
  const auto frames = PlaneScene().Render(SidewaysPath(2));
  std::vector<SeedState> first;
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    const std::unique_ptr<Backend> backend = MakeBackendOf(GetParam(), PlantingEvery(1));
    std::size_t born = 0;
    tbb::task_arena(threads).execute([&] {
      born = PlantAll(frames[0], backend.get());
      Update(frames[0], frames[1], born, backend.get());
    });
    const std::vector<SeedState> states = backend->Read(0, born, 1);
    ASSERT_GT(states.size(), 20'000U);
    if (threads == 1) first = states;
    EXPECT_TRUE(std::ranges::equal(states, first, SameNumbers)) << threads;
    EXPECT_TRUE(std::ranges::equal(states, first, SameCounts)) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         BackendTest,
                         ::testing::ValuesIn(BackendKinds()),
                         [](const ::testing::TestParamInfo<std::string>& tested) {
                           return testing_support::TestNameOf(tested.param);
                         });

TEST(MakeBackendTest, AutoIsTheCpuWhereThereIsNoGpu) {
  Options options = TestOptions();
  options.backend = BackendChoice::kAuto;
  const bool gpu = !FindCudaDevices().devices.empty();
  EXPECT_TRUE(MakeBackend(options)->name().starts_with(gpu ? "CUDA" : "CPU"));
  options.backend = BackendChoice::kCpu;
  EXPECT_TRUE(MakeBackend(options)->name().starts_with("CPU"));
  if (gpu) return;
  options.backend = BackendChoice::kCuda;
  EXPECT_THROW(MakeBackend(options), DeviceError);
}

}  // namespace
}  // namespace livemvs
