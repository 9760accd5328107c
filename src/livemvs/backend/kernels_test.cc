#include "livemvs/backend/backend.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <thread>

#include "livemvs/backend/cpu/kernels.h"
#include "livemvs/backend/cpu/row_pairs.h"
#include "livemvs/reference/algorithm1.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

constexpr double kNear = 0.7, kFar = 1.6;

// Made once: its table takes a while. All options here have these two numbers.
const OutlierRule& Rule() {
  static const OutlierRule rule(0.05, 0.99);
  return rule;
}

// The columns of a few thousand seeds of one frame.
struct Columns {
  std::vector<float> mu, sigma2, a, b, c0, c1, bearing_x, bearing_y;
  std::vector<std::uint8_t> patch;
  std::vector<SeedCounts> counts;
  std::vector<Fate> fate;

  explicit Columns(const std::vector<reference::Seed>& seeds) {
    for (const reference::Seed& s : seeds) {
      mu.push_back(static_cast<float>(s.posterior.mu));
      sigma2.push_back(static_cast<float>(s.posterior.sigma2));
      a.push_back(static_cast<float>(s.posterior.a));
      b.push_back(static_cast<float>(s.posterior.b));
      c0.push_back(static_cast<float>(s.interval.c0));
      c1.push_back(static_cast<float>(s.interval.c1));
      bearing_x.push_back(static_cast<float>(s.bearing_x));
      bearing_y.push_back(static_cast<float>(s.bearing_y));
      patch.insert(patch.end(), s.patch.begin(), s.patch.end());
      counts.push_back(s.counts);
      fate.push_back(s.fate);
    }
    patch.resize(patch.size() + 8);  // padding, see SeedColumns
  }

  SeedColumns View() {
    return {mu.data(),
            sigma2.data(),
            a.data(),
            b.data(),
            c0.data(),
            c1.data(),
            bearing_x.data(),
            bearing_y.data(),
            patch.data(),
            counts.data(),
            fate.data()};
  }

  bool operator==(const Columns& o) const {
    const auto same = [](const auto& x, const auto& y) {
      return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
    };
    return same(mu, o.mu) && same(sigma2, o.sigma2) && same(a, o.a) && same(b, o.b) &&
           same(counts, o.counts) && same(fate, o.fate) && same(patch, o.patch);
  }

  // The reference's seed takes over the state of entry i.
  void CopyTo(std::size_t i, reference::Seed* seed) const {
    seed->posterior = {mu[i], sigma2[i], a[i], b[i]};
    seed->counts = counts[i];
    seed->fate = fate[i];
  }
};

std::vector<reference::Seed> Plant(const Options& options, const PosedFrame& frame, int step) {
  std::vector<reference::Seed> seeds;
  for (int y = 3; y < frame.camera.height - 3; y += step) {
    for (int x = 3; x < frame.camera.width - 3; x += step) {
      seeds.push_back(reference::MakeSeed(options, frame, x, y, kNear, kFar));
    }
  }
  return seeds;
}

SeedGroup GroupOf(const PosedFrame& ref, const PosedFrame& cur, std::size_t seeds) {
  return {0,
          seeds,
          0,
          MakeRelativeView<float>(ref.camera, ref.cam_from_world, cur.camera, cur.cam_from_world),
          static_cast<float>(1 / ref.camera.FocalLength())};
}

UpdateStatistics RunKernel(const NamedKernel& kernel,
                           const Options& options,
                           const SeedGroup& group,
                           const PosedFrame& cur,
                           bool warp,
                           Columns* columns) {
  RowPairs pairs;
  pairs.Build(cur.picture->grey.view());
  const UpdateJob job = {&options,
                         &Rule(),
                         columns->View(),
                         &group,
                         cur.camera.model,
                         {cur.picture->grey.view(), pairs.view()},
                         warp};
  return kernel.update(job, group.begin, group.end);
}

MatchStatus StatusOf(const UpdateStatistics& one_seed) {
  if (one_seed.matched) return MatchStatus::kMatched;
  if (one_seed.no_information) return MatchStatus::kNoInformation;
  return one_seed.out_of_view ? MatchStatus::kOutOfView : MatchStatus::kMismatch;
}

struct Agreement {
  int updates = 0;
  int matched = 0;
  int other_status = 0;
  int other_fate = 0;
  int other_peak = 0;               // matched both, but at another maximum
  double worst_mu = 0;              // over sigma
  double mean_mu = 0;               // over sigma
  double worst_sigma2 = 0;          // relative
  double worst_a = 0, worst_b = 0;  // relative
};

// Every seed meets every frame in both implementations, each time from the same state, so that one
// tie does not spoil all that follows.
Agreement Compare(const Options& options,
                  const std::vector<PosedFrame>& frames,
                  bool warp,
                  int step,
                  int level = 0) {
  Agreement result;
  double sum_mu = 0;
  int compared = 0;
  std::vector<reference::Seed> seeds = Plant(options, frames[0], step);
  Columns columns(seeds);
  for (std::size_t f = 1; f < frames.size(); ++f) {
    const PosedFrame& cur = frames[f];
    SeedGroup group = GroupOf(frames[0], cur, seeds.size());
    group.level = level;
    const reference::Meeting meeting = {
        cur.picture->grey.view(), Projector(cur.camera), cur.cam_from_world, warp, level};
    RowPairs pairs;
    pairs.Build(cur.picture->grey.view());
    const UpdateJob job = {&options,
                           &Rule(),
                           columns.View(),
                           &group,
                           cur.camera.model,
                           {cur.picture->grey.view(), pairs.view()},
                           warp};
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      if (columns.fate[i] != Fate::kAlive) continue;
      columns.CopyTo(i, &seeds[i]);
      const MatchStatus status = StatusOf(UsableKernels().front().update(job, i, i + 1));
      const MatchStatus expected = reference::UpdateSeed(options, meeting, &seeds[i]).status;
      ++result.updates;
      if (status != expected) {
        ++result.other_status;
        continue;
      }
      if (status == MatchStatus::kMatched) ++result.matched;
      result.other_fate += columns.fate[i] != seeds[i].fate;
      const Posterior<double>& q = seeds[i].posterior;
      const double mu_error = std::abs(columns.mu[i] - q.mu) / std::sqrt(q.sigma2);
      if (mu_error > 0.2) {
        ++result.other_peak;
        continue;
      }
      result.worst_mu = std::max(result.worst_mu, mu_error);
      sum_mu += mu_error;
      ++compared;
      result.worst_sigma2 =
          std::max(result.worst_sigma2, std::abs(columns.sigma2[i] / q.sigma2 - 1));
      result.worst_a = std::max(result.worst_a, std::abs(columns.a[i] / q.a - 1));
      result.worst_b = std::max(result.worst_b, std::abs(columns.b[i] / q.b - 1));
    }
  }
  result.mean_mu = sum_mu / compared;
  return result;
}

// Decisions at thresholds (a score of just min_ncc, two equal maxima, a patch that just touches the
// border) may fall either way in float and double.
constexpr double kTies = 0.003;
// The kernels interpolate and multiply in integers of 16 bits (1/127 of a pixel, 1/32 of a grey
// level): the vertex of the parabola through the scores moves by some thousandths of a pixel, and
// by more where the maximum is flat. In standard deviations of the posterior, for all seeds and on
// average.
constexpr double kMuTolerance = 0.12;
constexpr double kMeanMuTolerance = 0.003;
// Through the weight w1, from the same cause.
constexpr double kRelativeTolerance = 0.06;

void ExpectAgreement(const Agreement& r, double tolerance_factor = 1) {
  EXPECT_GT(r.matched, r.updates / 4) << "too little to compare";
  EXPECT_LE(r.other_status, kTies * r.updates);
  EXPECT_LE(r.other_fate, kTies * r.updates);
  EXPECT_LE(r.other_peak, kTies * r.updates);
  EXPECT_LT(r.worst_mu, tolerance_factor * kMuTolerance);
  EXPECT_LT(r.mean_mu, tolerance_factor * kMeanMuTolerance);
  EXPECT_LT(r.worst_sigma2, tolerance_factor * kRelativeTolerance);
  EXPECT_LT(r.worst_a, tolerance_factor * kRelativeTolerance);
  EXPECT_LT(r.worst_b, tolerance_factor * kRelativeTolerance);
}

class AgainstReference : public ::testing::TestWithParam<CameraModel> {};

PlaneScene SceneOf(CameraModel model) {
  PlaneScene scene;
  scene.camera.model = model;
  if (model == CameraModel::kBrownConrady) scene.camera.distortion = {-0.15, 0.05, 5e-4, -3e-4};
  if (model == CameraModel::kKannalaBrandt) scene.camera.distortion = {-0.02, 0.006, -0.003, 4e-4};
  return scene;
}

TEST_P(AgainstReference, DepthAndInverseDepth) {
  const auto frames = SceneOf(GetParam()).Render(SidewaysPath(12));
  // The reference follows the bent line of a distorted image, the kernel its tangent: a tenth of a
  // pixel at the window's end, and through the weight some per cent of the variance.
  const double factor = GetParam() == CameraModel::kPinhole ? 1 : 4;
  for (const auto coordinate : {DepthCoordinate::kDepth, DepthCoordinate::kInverseDepth}) {
    Options options = TestOptions();
    options.coordinate = coordinate;
    // Thousands of seeds where it is quick.
    const int step = GetParam() == CameraModel::kPinhole ? 3 : 8;
    ExpectAgreement(Compare(options, frames, false, step), factor);
  }
}

INSTANTIATE_TEST_SUITE_P(Models,
                         AgainstReference,
                         ::testing::Values(CameraModel::kPinhole,
                                           CameraModel::kBrownConrady,
                                           CameraModel::kKannalaBrandt));

TEST(AgainstReference, PaperOptions) {
  const auto frames = PlaneScene().Render(SidewaysPath(12));
  Options options = PaperOptions();
  options.search = Search::kWindow;
  ExpectAgreement(Compare(options, frames, false, 5));
}

// A frame as level 1 of its pyramid.
PosedFrame Halved(const PosedFrame& frame) {
  PosedFrame half = frame;
  half.camera = AtLevel(frame.camera, 1);
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(half.camera.width, half.camera.height);
  const Image<std::uint8_t>& grey = frame.picture->grey;
  for (int y = 0; y < half.camera.height; ++y) {
    for (int x = 0; x < half.camera.width; ++x) {
      picture->grey(x, y) =
          static_cast<std::uint8_t>((grey(2 * x, 2 * y) + grey(2 * x + 1, 2 * y) +
                                     grey(2 * x, 2 * y + 1) + grey(2 * x + 1, 2 * y + 1) + 2) /
                                    4);
    }
  }
  half.picture = picture;
  return half;
}

TEST(AgainstReference, CoarseLevel) {
  std::vector<PosedFrame> frames = PlaneScene().Render(SidewaysPath(12));
  for (PosedFrame& frame : frames) frame = Halved(frame);
  ExpectAgreement(Compare(TestOptions(), frames, false, 2, 1));
}

TEST(AgainstReference, TurnedAndScaledPatches) {
  std::vector<Rigid3d> poses = SidewaysPath(12);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Matrix3d roll =
        Eigen::AngleAxisd(0.08 * static_cast<double>(i), Eigen::Vector3d::UnitZ())
            .toRotationMatrix();
    poses[i] = Rigid3d{roll, {0, 0, -0.015 * static_cast<double>(i)}} * poses[i];
  }
  ExpectAgreement(Compare(TestOptions(), PlaneScene().Render(poses), true, 5));
}

TEST(KernelsTest, InstructionSetsAgreeBitForBit) {
  const std::vector<NamedKernel> kernels = UsableKernels();
  ASSERT_FALSE(kernels.empty());
  for (const auto model :
       {CameraModel::kPinhole, CameraModel::kBrownConrady, CameraModel::kKannalaBrandt}) {
    const auto frames = SceneOf(model).Render(SidewaysPath(4));
    for (const auto search : {Search::kWindow, Search::kFull}) {
      for (const bool warp : {false, true}) {
        if (search == Search::kFull && model != CameraModel::kPinhole) continue;
        Options options = TestOptions();
        options.search = search;
        const auto seeds = Plant(options, frames[0], 5);
        std::vector<Columns> results;
        for (const NamedKernel& kernel : kernels) {
          Columns columns(seeds);
          for (std::size_t f = 1; f < frames.size(); ++f) {
            RunKernel(kernel,
                      options,
                      GroupOf(frames[0], frames[f], seeds.size()),
                      frames[f],
                      warp,
                      &columns);
          }
          results.push_back(std::move(columns));
          EXPECT_TRUE(results.back() == results.front())
              << kernel.name << " differs from " << kernels.front().name << ", model "
              << ToString(model) << ", warp " << warp;
        }
      }
    }
  }
}

// What one frame does to fresh seeds.
struct Outcome {
  UpdateStatistics statistics;
  Columns before, after;
};

Outcome Meet(const Options& options, const PosedFrame& ref, const PosedFrame& cur) {
  const auto seeds = Plant(options, ref, 3);
  Outcome outcome{{}, Columns(seeds), Columns(seeds)};
  outcome.statistics = RunKernel(UsableKernels().front(),
                                 options,
                                 GroupOf(ref, cur, seeds.size()),
                                 cur,
                                 false,
                                 &outcome.after);
  return outcome;
}

TEST(KernelsTest, NoBaselineTellsNothing) {
  const PlaneScene scene;
  const PosedFrame ref = scene.Render(Rigid3d{}, 0);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
  for (const Rigid3d& pose : {Rigid3d{}, Rigid3d{turn, {0, 0, 0}}}) {
    const Outcome o = Meet(TestOptions(), ref, scene.Render(pose, 1));
    EXPECT_EQ(o.statistics.matched, 0);
    EXPECT_EQ(o.statistics.mismatched, 0);
    EXPECT_GT(o.statistics.no_information, o.statistics.total() / 2);
    EXPECT_EQ(o.before.mu, o.after.mu);
    EXPECT_EQ(o.before.b, o.after.b);
  }
}

TEST(KernelsTest, OutOfViewTellsNothing) {
  const PlaneScene scene;
  const PosedFrame ref = scene.Render(Rigid3d{}, 0);
  PosedFrame cur = ref;
  cur.cam_from_world = {Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                        {0.1, 0, 0}};
  const Outcome behind = Meet(TestOptions(), ref, cur);
  EXPECT_EQ(behind.statistics.out_of_view, behind.statistics.total());
  EXPECT_EQ(behind.before.b, behind.after.b);
  cur.cam_from_world = {Eigen::Matrix3d::Identity(), {5, 0, 0}};
  const Outcome aside = Meet(TestOptions(), ref, cur);
  EXPECT_EQ(aside.statistics.out_of_view, aside.statistics.total());
  for (const SeedCounts& c : aside.after.counts) {
    EXPECT_EQ(c.unseen, 1);
    EXPECT_EQ(c.age, 0);
  }
}

TEST(KernelsTest, ABlackPictureIsAMismatch) {
  const PlaneScene scene;
  const PosedFrame ref = scene.Render(Rigid3d{}, 0);
  PosedFrame cur = ref;
  cur.cam_from_world.translation.x() = -0.02;
  auto black = std::make_shared<Picture>();
  black->grey = Image<std::uint8_t>(scene.camera.width, scene.camera.height);
  cur.picture = black;
  const Outcome o = Meet(TestOptions(), ref, cur);
  EXPECT_EQ(o.statistics.matched, 0);
  EXPECT_GT(o.statistics.mismatched, o.statistics.total() / 2);
  EXPECT_EQ(o.before.mu, o.after.mu);
  EXPECT_EQ(o.before.sigma2, o.after.sigma2);
}

TEST(KernelsTest, ManySeedsAtOnceDoAsOneByOne) {
  const auto frames = PlaneScene().Render(SidewaysPath(5));
  const auto seeds = Plant(TestOptions(), frames[0], 2);
  for (const bool warp : {false, true}) {
    // A block and a lane more or less than whole ones.
    for (const std::size_t n : {1U, 3U, 15U, 17U, 1023U, 1025U, 2000U}) {
      ASSERT_GE(seeds.size(), n);
      const std::vector<reference::Seed> some(seeds.begin(), seeds.begin() + n);
      for (const NamedKernel& kernel : UsableKernels()) {
        Columns together(some), single(some);
        for (std::size_t i = 5; i < n; i += 7) {
          together.fate[i] = single.fate[i] = Fate::kRemoved;
        }
        for (std::size_t f = 1; f < frames.size(); ++f) {
          SeedGroup group = GroupOf(frames[0], frames[f], n);
          const UpdateStatistics all =
              RunKernel(kernel, TestOptions(), group, frames[f], warp, &together);
          UpdateStatistics sum;
          for (std::size_t i = 0; i < n; ++i) {
            group.begin = i;
            group.end = i + 1;
            sum += RunKernel(kernel, TestOptions(), group, frames[f], warp, &single);
          }
          EXPECT_EQ(all.matched, sum.matched);
          EXPECT_EQ(all.total(), sum.total());
        }
        EXPECT_TRUE(together == single) << kernel.name << ", " << n << " seeds, warp " << warp;
      }
    }
  }
}

TEST(KernelsTest, ExtremeContrastMatchesAsAnyOther) {
  // Patches of 0 and 255 reach the ends of the 16-bit arithmetic.
  PosedFrame ref = PlaneScene().Render(SidewaysPath(2))[0];
  std::mt19937 random(11);
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(ref.camera.width, ref.camera.height);
  for (int y = 0; y < ref.camera.height; ++y) {
    for (int x = 0; x < ref.camera.width; ++x) picture->grey(x, y) = random() % 2 == 0 ? 0 : 255;
  }
  ref.picture = picture;
  // The same picture a whole number of pixels further on: a plane at a depth that is known.
  constexpr int kShift = 3;
  constexpr double kDepth = 0.5 * (kNear + kFar);
  PosedFrame cur = ref;
  auto moved = std::make_shared<Picture>();
  moved->grey = Image<std::uint8_t>(ref.camera.width, ref.camera.height);
  for (int y = 0; y < ref.camera.height; ++y) {
    for (int x = kShift; x < ref.camera.width; ++x) {
      moved->grey(x, y) = picture->grey(x - kShift, y);
    }
  }
  cur.picture = moved;
  cur.cam_from_world.translation.x() += kShift * kDepth / ref.camera.fx;
  const Options options = TestOptions();
  const auto seeds = Plant(options, ref, 5);
  for (const bool warp : {false, true}) {
    for (const NamedKernel& kernel : UsableKernels()) {
      Columns columns(seeds);
      const SeedGroup group = GroupOf(ref, cur, seeds.size());
      const UpdateStatistics s = RunKernel(kernel, options, group, cur, warp, &columns);
      EXPECT_GT(s.matched, static_cast<std::int64_t>(seeds.size()) * 8 / 10) << kernel.name;
    }
  }
}

TEST(RowPairsTest, HoldEachPixelBesideTheOneBelow) {
  Image<std::uint8_t> image(7, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) image(x, y) = static_cast<std::uint8_t>(37 * x + 91 * y);
  }
  RowPairs pairs;
  pairs.Build(image.view());
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      const std::uint16_t pair = pairs.view()(x, y);
      EXPECT_EQ(static_cast<std::int8_t>(pair & 255), image(x, y) - 128);
      EXPECT_EQ(static_cast<std::int8_t>(pair >> 8), image(x, std::min(y + 1, 4)) - 128);
    }
  }
}

TEST(KernelsTest, PicturesTooSmallForTheWarpedPatchAreNotSearched) {
  // Four times the focal length: the patch reaches further than the picture.
  const auto frames = PlaneScene().Render(SidewaysPath(3));
  PosedFrame small = frames[2];
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(16, 16);
  small.picture = picture;
  small.camera.width = small.camera.height = 16;
  small.camera.fx *= 4;
  small.camera.fy *= 4;
  small.camera.cx = small.camera.cy = 7.5;
  const auto seeds = Plant(TestOptions(), frames[0], 5);
  for (const NamedKernel& kernel : UsableKernels()) {
    Columns columns(seeds);
    const SeedGroup group = GroupOf(frames[0], small, seeds.size());
    const UpdateStatistics s = RunKernel(kernel, TestOptions(), group, small, true, &columns);
    EXPECT_EQ(s.matched + s.mismatched, 0) << kernel.name;
    EXPECT_EQ(s.total(), static_cast<std::int64_t>(seeds.size())) << kernel.name;
  }
}

TEST(CpuBackendTest, TheEnvironmentChoosesTheInstructions) {
  for (const NamedKernel& kernel : UsableKernels()) {
    ::setenv(kInstructionsVariable, kernel.name, 1);
    EXPECT_EQ(MakeCpuBackend(Options())->name(), std::string("CPU, ") + kernel.name);
  }
  ::setenv(kInstructionsVariable, "MMX", 1);
  EXPECT_THROW(MakeCpuBackend(Options()), std::invalid_argument);
  ::unsetenv(kInstructionsVariable);
  EXPECT_EQ(MakeCpuBackend(Options())->name(), std::string("CPU, ") + UsableKernels().front().name);
}

TEST(KernelsTest, MarksThePixelsThatLivingSeedsProjectTo) {
  const auto frames = PlaneScene().Render(SidewaysPath(3));
  const auto seeds = Plant(TestOptions(), frames[0], 5);
  const SeedGroup group = GroupOf(frames[0], frames[2], seeds.size());
  for (const NamedKernel& kernel : UsableKernels()) {
    Columns columns(seeds);
    for (std::size_t i = 0; i < seeds.size(); i += 3) columns.fate[i] = Fate::kRemoved;
    Image<std::uint8_t> marks(frames[2].camera.width, frames[2].camera.height);
    Image<std::uint8_t> expected(marks.width(), marks.height());
    const MarkJob job = {TestOptions().coordinate,
                         columns.View(),
                         &group,
                         frames[2].camera.model,
                         {marks.Row(0), marks.width(), marks.height(), marks.stride()}};
    // Twice at once, as threads do whose seeds project to the same pixel.
    std::thread other([&] { kernel.mark(job, 0, seeds.size()); });
    kernel.mark(job, 0, seeds.size());
    other.join();
    const Projector projector(frames[2].camera);
    int near_two_pixels = 0, marked = 0;
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      if (columns.fate[i] != Fate::kAlive) continue;
      const DepthEstimate<float> z = DepthOf<float>(
          TestOptions().coordinate, {columns.c0[i], columns.c1[i]}, columns.mu[i], 0);
      const Eigen::Vector3d ray(columns.bearing_x[i], columns.bearing_y[i], 1);
      const Eigen::Vector3d point =
          frames[0].cam_from_world.Inverse() * Eigen::Vector3d(ray.normalized() * double{z.depth});
      const auto pixel = projector.Project(frames[2].cam_from_world * point);
      if (!pixel || !frames[2].camera.Contains(*pixel)) continue;
      const auto x = static_cast<int>(std::lround(pixel->x()));
      const auto y = static_cast<int>(std::lround(pixel->y()));
      // Halves may be rounded either way.
      near_two_pixels += marks(x, y) == 0;
      expected(x, y) = 1;
      ++marked;
    }
    EXPECT_GT(marked, 500) << kernel.name;
    EXPECT_LE(near_two_pixels, marked / 500) << kernel.name;
    int unexpected = 0;
    for (int y = 0; y < marks.height(); ++y) {
      for (int x = 0; x < marks.width(); ++x) unexpected += marks(x, y) != 0 && expected(x, y) == 0;
    }
    EXPECT_LE(unexpected, marked / 500) << kernel.name;
  }
}

}  // namespace
}  // namespace livemvs
