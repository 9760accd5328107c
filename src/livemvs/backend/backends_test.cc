// What every backend must do, and that all give the same: those of the CPU, and the GPU's where
// there is one.

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <ostream>
#include <set>
#include <stdexcept>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/cpu/kernels.h"
#include "livemvs/backend/cuda/cuda_backend.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

constexpr double kNear = 0.7, kFar = 1.6;
constexpr Posterior<float> kPrior = {0.5F, 0.04F, 5, 5};
constexpr const char* kCuda = "CUDA";

std::unique_ptr<Backend> Make(const std::string& kind, const Options& options) {
  if (kind == kCuda) return MakeCudaBackend(options);
  ::setenv(kInstructionsVariable, kind.c_str(), 1);
  std::unique_ptr<Backend> backend = MakeCpuBackend(options);
  ::unsetenv(kInstructionsVariable);
  return backend;
}

bool SameNumbers(const SeedState& a, const SeedState& b) {
  return a.posterior.mu == b.posterior.mu && a.posterior.sigma2 == b.posterior.sigma2 &&
         a.posterior.a == b.posterior.a && a.posterior.b == b.posterior.b;
}

bool SameCounts(const SeedState& a, const SeedState& b) {
  return a.counts.age == b.counts.age && a.counts.views == b.counts.views &&
         a.counts.unseen == b.counts.unseen && a.fate == b.fate;
}

// Seeds on every step-th pixel of a frame, at one level of its pyramid.
std::vector<NewSeed> Newborns(const PosedFrame& frame, int step) {
  std::vector<NewSeed> seeds;
  const Projector projector(frame.camera);
  const Image<std::uint8_t>& grey = frame.picture->grey;
  for (int y = 3; y < frame.camera.height - 3; y += step) {
    for (int x = 3; x < frame.camera.width - 3; x += step) {
      const Eigen::Vector3d ray = *projector.Unproject({x, y});
      seeds.push_back({{static_cast<float>(1 / kNear), static_cast<float>(1 / kFar)},
                       static_cast<float>(ray.x()),
                       static_cast<float>(ray.y()),
                       &grey(x, y),
                       grey.stride()});
    }
  }
  return seeds;
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
    if (GetParam() != kCuda) return;
    const CudaDevices found = FindCudaDevices();
    if (found.devices.empty()) GTEST_SKIP() << found.trouble;
  }

  static Options OptionsFor(std::size_t seeds) {
    Options options = TestOptions();
    options.max_seeds = static_cast<int>(seeds);
    return options;
  }

  static UpdateStatistics Update(const PosedFrame& ref,
                                 const PosedFrame& cur,
                                 std::size_t seeds,
                                 Backend* backend) {
    const ImageView<std::uint8_t> pyramid[] = {cur.picture->grey.view()};
    // Two groups, of which the first does not end with a whole block.
    const std::size_t middle = seeds / 3;
    return backend->Update({GroupOf(ref, cur, 0, middle), GroupOf(ref, cur, middle, seeds)},
                           cur.camera.model,
                           pyramid);
  }

  // Runs both backends over the frames, from the same seeds; the GPU's library rounds the arc
  // tangent of fisheye lenses in its own way, whence `tolerance`.
  static void ExpectSame(const std::vector<PosedFrame>& frames,
                         const Options& options,
                         double tolerance) {
    const std::vector<NewSeed> born = Newborns(frames[0], 2);
    Options enough = options;
    enough.max_seeds = static_cast<int>(born.size());
    const std::unique_ptr<Backend> expected = Make("single lane", enough);
    const std::unique_ptr<Backend> backend = Make(GetParam(), enough);
    expected->Append(born, kPrior);
    backend->Append(born, kPrior);
    std::int64_t matched = 0;
    for (std::size_t f = 1; f < frames.size(); ++f) {
      const UpdateStatistics a = Update(frames[0], frames[f], born.size(), expected.get());
      const UpdateStatistics b = Update(frames[0], frames[f], born.size(), backend.get());
      const auto share = tolerance > 0 ? static_cast<double>(born.size()) / 500 : 0;
      EXPECT_NEAR(static_cast<double>(a.matched), static_cast<double>(b.matched), share);
      EXPECT_EQ(a.total(), b.total());
      matched += a.matched;
    }
    EXPECT_GT(matched, static_cast<std::int64_t>(born.size())) << "too little to compare";
    const std::vector<SeedState> want = expected->Read(0, born.size(), 1);
    const std::vector<SeedState> have = backend->Read(0, born.size(), 1);
    ASSERT_EQ(want.size(), have.size());
    std::size_t other_counts = 0, other_numbers = 0;
    for (std::size_t i = 0; i < want.size(); ++i) {
      other_counts += !SameCounts(want[i], have[i]);
      other_numbers += tolerance > 0
                           ? std::abs(want[i].posterior.mu - have[i].posterior.mu) > tolerance
                           : !SameNumbers(want[i], have[i]);
    }
    const std::size_t allowed = tolerance > 0 ? born.size() / 500 : 0;
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
  const std::vector<NewSeed> born = Newborns(frames[0], 1);
  Options options = OptionsFor(born.size());
  options.max_age = 1;  // all end that tell something
  options.min_views = 200;
  const std::unique_ptr<Backend> backend = Make(GetParam(), options);
  backend->Append(born, kPrior);
  EXPECT_EQ(Update(frames[0], frames[1], born.size(), backend.get()).total(),
            static_cast<std::int64_t>(born.size()));
  const auto ended = static_cast<std::int64_t>(backend->TakeEnded().size());
  EXPECT_GT(ended, static_cast<std::int64_t>(born.size()) / 2);
  EXPECT_EQ(Update(frames[0], frames[2], born.size(), backend.get()).total(),
            static_cast<std::int64_t>(born.size()) - ended);
}

TEST_P(BackendTest, GivesEachEndedSeedOnceAndClosesGapsInOrder) {
  const auto frames = PlaneScene().Render(SidewaysPath(2));
  const std::vector<NewSeed> born = Newborns(frames[0], 1);
  Options options = OptionsFor(born.size());
  options.max_age = 1;
  options.min_views = 200;
  const std::unique_ptr<Backend> backend = Make(GetParam(), options);
  backend->Append(born, kPrior);
  Update(frames[0], frames[1], born.size(), backend.get());
  const std::vector<SeedState> before = backend->Read(0, born.size(), 1);
  const std::vector<std::uint8_t> patches = backend->ReadPatches(0, born.size());
  const auto span = backend->TakeEnded();
  const std::vector<EndedSeed> ended(span.begin(), span.end());
  ASSERT_FALSE(ended.empty());
  ASSERT_LT(ended.size(), born.size());
  EXPECT_TRUE(std::ranges::is_sorted(ended, {}, &EndedSeed::slot));
  std::set<std::size_t> gone;
  for (const EndedSeed& e : ended) {
    EXPECT_TRUE(SameNumbers(e.seed, before[e.slot]) && SameCounts(e.seed, before[e.slot]));
    EXPECT_NE(e.seed.fate, Fate::kAlive);
    EXPECT_TRUE(gone.insert(e.slot).second);
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].fate != Fate::kAlive, gone.contains(i)) << i;
  }
  EXPECT_TRUE(backend->TakeEnded().empty());
  EXPECT_THROW(backend->Append({born.data(), 1}, kPrior), std::length_error);

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
  backend->Append({born.data(), ended.size()}, kPrior);
  const std::vector<SeedState> anew = backend->Read(kept.size(), born.size(), 1);
  ASSERT_EQ(anew.size(), ended.size());
  EXPECT_EQ(anew.front().bearing_x, born.front().bearing_x);
  EXPECT_EQ(anew.front().counts.age, 0);
  EXPECT_EQ(anew.front().fate, Fate::kAlive);
}

TEST_P(BackendTest, MarksPlacesAsTheOthersDo) {
  const auto frames = PlaneScene().Render(SidewaysPath(3));
  const std::vector<NewSeed> born = Newborns(frames[0], 5);
  const std::vector<SeedGroup> groups = {GroupOf(frames[0], frames[2], 0, born.size())};
  std::vector<Image<std::uint8_t>> marks;
  for (const std::string& kind : {std::string("single lane"), GetParam()}) {
    const std::unique_ptr<Backend> backend = Make(kind, OptionsFor(born.size()));
    backend->Append(born, kPrior);
    std::vector<Image<std::uint8_t>> picture;
    picture.emplace_back(frames[2].camera.width, frames[2].camera.height);
    backend->MarkPlaces(groups, frames[2].camera.model, picture);
    marks.push_back(std::move(picture[0]));
  }
  int marked = 0;
  for (int y = 0; y < marks[0].height(); ++y) {
    for (int x = 0; x < marks[0].width(); ++x) {
      marked += marks[0](x, y);
      ASSERT_EQ(marks[0](x, y), marks[1](x, y)) << x << ", " << y;
    }
  }
  EXPECT_GT(marked, 500);
}

TEST_P(BackendTest, ResultsDoNotDependOnTheThreads) {
  const auto frames = PlaneScene().Render(SidewaysPath(2));
  const std::vector<NewSeed> born = Newborns(frames[0], 1);
  std::vector<SeedState> first;
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    const std::unique_ptr<Backend> backend = Make(GetParam(), OptionsFor(born.size()));
    tbb::task_arena(threads).execute([&] {
      backend->Append(born, kPrior);
      Update(frames[0], frames[1], born.size(), backend.get());
    });
    const std::vector<SeedState> states = backend->Read(0, born.size(), 1);
    if (threads == 1) first = states;
    EXPECT_TRUE(std::ranges::equal(states, first, SameNumbers)) << threads;
    EXPECT_TRUE(std::ranges::equal(states, first, SameCounts)) << threads;
  }
}

std::vector<std::string> Kinds() {
  std::vector<std::string> kinds;
  for (const NamedKernel& kernel : UsableKernels()) kinds.emplace_back(kernel.name);
  kinds.emplace_back(kCuda);
  return kinds;
}

INSTANTIATE_TEST_SUITE_P(All,
                         BackendTest,
                         ::testing::ValuesIn(Kinds()),
                         [](const ::testing::TestParamInfo<std::string>& tested) {
                           std::string name = tested.param;
                           std::erase_if(name, [](unsigned char c) { return !std::isalnum(c); });
                           return name;
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
