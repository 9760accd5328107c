#include "livemvs/pipeline/reconstructor.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <memory>

#include "livemvs/backend/cuda/cuda_backend.h"
#include "livemvs/core/lean.h"
#include "livemvs/reference/algorithm1.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

constexpr int kFrames = 30;

SceneRange NearFar(double unit = 1) {
  SceneRange range;
  range.near = 0.6 * unit;
  range.far = 1.8 * unit;
  return range;
}

struct Result {
  PointCloud points;
  ReconstructionStatistics statistics;
  std::size_t live = 0;
};

Result Reconstruct(const Options& options,
                   const SceneRange& range,
                   const std::vector<PosedFrame>& frames) {
  Reconstructor reconstructor(options, range);
  std::size_t returned = 0;
  for (const PosedFrame& frame : frames) returned += reconstructor.AddFrame(frame).size();
  EXPECT_EQ(returned, reconstructor.points().size());
  return {reconstructor.points(), reconstructor.statistics(), reconstructor.live_seeds()};
}

const std::vector<PosedFrame>& PlaneFrames() {
  static const auto* frames =
      new std::vector<PosedFrame>(PlaneScene().Render(SidewaysPath(kFrames)));
  return *frames;
}

// The same pictures of a world that is measured in another unit.
std::vector<PosedFrame> Scaled(std::vector<PosedFrame> frames, double unit) {
  for (PosedFrame& f : frames) f.cam_from_world.translation *= unit;
  return frames;
}

bool Identical(const PointCloud& a, const PointCloud& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].position != b[i].position || a[i].normal != b[i].normal || a[i].color != b[i].color ||
        a[i].sigma != b[i].sigma || a[i].inlier_ratio != b[i].inlier_ratio ||
        a[i].views != b[i].views) {
      return false;
    }
  }
  return true;
}

TEST(ReconstructorTest, FindsThePlane) {
  const Result r = Reconstruct(TestOptions(), NearFar(), PlaneFrames());
  ASSERT_GT(r.points.size(), 1000U);
  const double pixel = 1.0 / 190;  // width of a pixel at depth 1
  std::size_t good = 0;
  for (const Point& p : r.points) {
    good += std::abs(PlaneScene::HeightAbove(p.position.cast<double>())) < 3 * pixel;
    EXPECT_NEAR(p.normal.norm(), 1, 1e-5);
    EXPECT_GT(p.sigma, 0);
    EXPECT_GT(p.inlier_ratio, TestOptions().eta_inlier);
    EXPECT_GE(p.views, TestOptions().min_views);
  }
  EXPECT_GT(static_cast<double>(good), 0.99 * static_cast<double>(r.points.size()));
}

TEST(ReconstructorTest, PointsLeanTowardsTheirTexture) {
  PlaneScene scene;
  scene.plain_left = 0;
  std::vector<Rigid3d> rolled = SidewaysPath(kFrames);
  const Rigid3d roll{Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                     Eigen::Vector3d::Zero()};
  for (Rigid3d& cam_from_world : rolled) cam_from_world = roll * cam_from_world;
  Options options = TestOptions();
  options.levels = 2;
  options.max_texture_offset_px = 0;
  const Result result = Reconstruct(options, NearFar(), scene.Render(rolled));
  int beside = 0, within = 0, centred = 0, coarse = 0;
  double towards = 0;
  for (const Point& p : result.points) {
    // As far away as from the first camera, more or less.
    const double pixel = static_cast<double>(p.position.norm()) / scene.camera.FocalLength();
    EXPECT_NEAR(p.footprint, std::ldexp(pixel, p.level), 0.3 * std::ldexp(pixel, p.level));
    coarse += p.level == 1;
    if (p.position.x() < -0.7F * p.footprint) {
      // Whose texture begins beside them. That varies along the edge, too.
      ++beside;
      ASSERT_TRUE(Leans(p.lean));
      towards += static_cast<double>(LeanDirection(p.normal, p.lean).x());
    } else if (p.position.x() > 3 * p.footprint) {
      ++within;
      centred += p.lean == kLeanNowhere;
    }
  }
  EXPECT_GT(coarse, 20);
  ASSERT_GT(beside, 20);
  EXPECT_GT(towards, 0.85 * beside);
  EXPECT_GT(centred, within / 10);
}

TEST(ReconstructorTest, EverySeedHasOneEnd) {
  const Result r = Reconstruct(TestOptions(), NearFar(), PlaneFrames());
  const auto& s = r.statistics;
  EXPECT_EQ(s.frames, kFrames);
  EXPECT_EQ(s.seeds_converged, static_cast<std::int64_t>(r.points.size()));
  EXPECT_EQ(s.seeds_spawned,
            static_cast<std::int64_t>(r.live) + s.seeds_converged + s.rejected_outlier +
                s.rejected_aged + s.rejected_unseen + s.rejected_left_interval +
                s.rejected_one_sided);
}

TEST(ReconstructorTest, MatchesTheReference) {
  // Without thinning and covering both plant the same seeds; the clouds must be alike.
  Options options = TestOptions();
  options.max_seeds = 20'000;
  options.plant_every = 1;
  options.seed_spacing_px = 5;
  options.cover_radius_px = -1;
  options.epsilon_px = 2;
  options.prior_a = 3;
  options.prior_b = 3;
  const std::vector<PosedFrame> frames(PlaneFrames().begin(), PlaneFrames().begin() + 20);
  std::int64_t updates[2];
  for (const bool some : {false, true}) {  // frames are left out from the eighth on
    options.min_move = some ? 0.13F : 0;
    const Result fast = Reconstruct(options, NearFar(), frames);
    reference::Algorithm1 slow(options, 0.6, 1.8);
    for (const PosedFrame& f : frames) slow.AddFrame(f);
    const auto n = static_cast<double>(slow.points().size());
    ASSERT_GT(n, 300);
    EXPECT_NEAR(static_cast<double>(fast.points.size()), n, 0.02 * n);
    updates[some] = slow.updates();
    const auto m = static_cast<double>(slow.updates());
    EXPECT_NEAR(static_cast<double>(fast.statistics.updates.total()), m, 0.01 * m);
    const auto rms = [](const PointCloud& cloud) {
      double sum = 0;
      for (const Point& p : cloud) {
        const double h = PlaneScene::HeightAbove(p.position.cast<double>());
        sum += std::min(h * h, 1e-2);
      }
      return std::sqrt(sum / static_cast<double>(cloud.size()));
    };
    EXPECT_NEAR(rms(fast.points) / rms(slow.points()), 1, 0.1);
  }
  EXPECT_LT(static_cast<double>(updates[1]), 0.9 * static_cast<double>(updates[0]));
}

TEST(ReconstructorTest, PlantsInEveryNthFrame) {
  const struct {
    int option;
    Search search;
    int every;
  } cases[] = {{3, Search::kWindow, 3},
               {1, Search::kWindow, 1},
               {0, Search::kWindow, 6},
               {0, Search::kFull, 1},
               {2, Search::kFull, 2}};
  for (const auto& c : cases) {
    Options options = TestOptions();
    options.plant_every = c.option;
    options.search = c.search;
    options.max_seeds = 200'000;   // always room ...
    options.cover_radius_px = -1;  // ... and always somewhere to plant
    options.seed_spacing_px = 5;
    Reconstructor reconstructor(options, NearFar());
    std::int64_t before = 0;
    for (int i = 0; i < 7; ++i) {
      reconstructor.AddFrame(PlaneFrames()[i]);
      const std::int64_t spawned = reconstructor.statistics().seeds_spawned;
      EXPECT_EQ(spawned > before, i % c.every == 0) << "frame " << i << ", every " << c.every;
      before = spawned;
    }
  }
}

TEST(ReconstructorTest, TwoRunsAndAnyNumberOfThreadsGiveTheSameBytes) {
  Options options = TestOptions();
  options.levels = 3;
  const PointCloud first = Reconstruct(options, NearFar(), PlaneFrames()).points;
  ASSERT_GT(first.size(), 1000U);
  // More workers than cores, so that the number is real on any machine.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    options.threads = threads;
    EXPECT_TRUE(Identical(first, Reconstruct(options, NearFar(), PlaneFrames()).points)) << threads;
  }
}

// The frames of the plane with other pictures: f(x, y) at each pixel.
template <typename F>
std::vector<PosedFrame> FramesShowing(const F& f) {
  std::vector<PosedFrame> frames = PlaneFrames();
  for (PosedFrame& frame : frames) {
    auto picture = std::make_shared<Picture>();
    picture->grey = Image<std::uint8_t>(frame.camera.width, frame.camera.height);
    for (int y = 0; y < frame.camera.height; ++y) {
      for (int x = 0; x < frame.camera.width; ++x) {
        picture->grey(x, y) = static_cast<std::uint8_t>(f(x, y));
      }
    }
    frame.picture = picture;
  }
  return frames;
}

TEST(ReconstructorTest, SeedsWithoutTextureAlongTheLineGrowOld) {
  // Stripes along the camera's way: texture enough, and none that tells of depth.
  Options options = TestOptions();
  options.max_age = 5;
  Reconstructor reconstructor(options, NearFar());
  for (const PosedFrame& frame : FramesShowing([](int, int y) { return 128 + 50 * (y / 3 % 2); })) {
    reconstructor.AddFrame(frame);
  }
  EXPECT_GT(reconstructor.statistics().rejected_aged, 1000);
  EXPECT_EQ(reconstructor.points().size(), 0U);
}

TEST(ReconstructorTest, NothingIsPlantedOnRamps) {
  // A ramp of brightness: every patch has contrast, and NCC does not see it move.
  Options options = TestOptions();
  options.min_patch_stddev = 0.5F;
  Reconstructor reconstructor(options, NearFar());
  for (const PosedFrame& frame : FramesShowing([](int x, int) { return x; })) {
    reconstructor.AddFrame(frame);
  }
  EXPECT_EQ(reconstructor.statistics().seeds_spawned, 0);
}

TEST(ReconstructorTest, UnitsOfPowersOfTwoChangeNothingButTheUnit) {
  const PointCloud first = Reconstruct(TestOptions(), NearFar(), PlaneFrames()).points;
  for (const float unit : {1024.0F, 1.0F / 1024}) {
    const PointCloud scaled =
        Reconstruct(TestOptions(), NearFar(unit), Scaled(PlaneFrames(), unit)).points;
    ASSERT_EQ(scaled.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      ASSERT_EQ(scaled[i].position, first[i].position * unit) << i;
      ASSERT_EQ(scaled[i].sigma, first[i].sigma * unit) << i;
      ASSERT_EQ(scaled[i].inlier_ratio, first[i].inlier_ratio) << i;
    }
  }
}

// Clouds that differ by rounding: as many points, as accurate.
void ExpectAlike(const PointCloud& a, const PointCloud& b) {
  const auto n = static_cast<double>(a.size());
  EXPECT_NEAR(static_cast<double>(b.size()), n, 0.01 * n);
  const auto mean = [](const PointCloud& points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Point& p : points) sum += p.position.cast<double>();
    return Eigen::Vector3d(sum / static_cast<double>(points.size()));
  };
  EXPECT_LT((mean(a) - mean(b)).norm(), 2e-3);
}

TEST(ReconstructorTest, AnyUnitGivesTheSameScene) {
  const PointCloud first = Reconstruct(TestOptions(), NearFar(), PlaneFrames()).points;
  for (const double unit : {1000.0, 0.001}) {
    PointCloud scaled =
        Reconstruct(TestOptions(), NearFar(unit), Scaled(PlaneFrames(), unit)).points;
    for (Point& p : scaled) p.position /= static_cast<float>(unit);
    ExpectAlike(first, scaled);
  }
}

TEST(ReconstructorTest, TheWorldsFrameDoesNotMatter) {
  const Rigid3d new_from_old = {
      Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix(),
      {3, -2, 1}};
  std::vector<PosedFrame> frames = PlaneFrames();
  for (PosedFrame& f : frames) f.cam_from_world = f.cam_from_world * new_from_old.Inverse();
  PointCloud moved = Reconstruct(TestOptions(), NearFar(), frames).points;
  for (Point& p : moved) {
    p.position = (new_from_old.Inverse() * p.position.cast<double>()).cast<float>();
  }
  ExpectAlike(Reconstruct(TestOptions(), NearFar(), PlaneFrames()).points, moved);
}

TEST(ReconstructorTest, StillOrTurningCamerasNeitherRejectNorConverge) {
  for (const double turn : {0.0, 0.004}) {
    std::vector<Rigid3d> poses;
    for (int i = 0; i < 15; ++i) {
      poses.push_back({Eigen::AngleAxisd(turn * i, Eigen::Vector3d(0.3, 1, 0.4).normalized())
                           .toRotationMatrix(),
                       {0, 0, 0}});
    }
    Options options = TestOptions();
    options.min_move = 0;  // else there would be few updates that could do harm
    const Result r = Reconstruct(options, NearFar(), PlaneScene().Render(poses));
    EXPECT_GT(r.live, 1000U);
    EXPECT_GT(r.statistics.updates.no_information, 10'000);
    EXPECT_EQ(r.statistics.seeds_converged, 0);
    EXPECT_EQ(r.statistics.rejected_outlier, 0);
    EXPECT_EQ(r.statistics.rejected_aged, 0);
    EXPECT_EQ(r.statistics.rejected_left_interval, 0);
    EXPECT_EQ(r.statistics.updates.matched, 0);
    EXPECT_EQ(r.statistics.updates.mismatched, 0);
  }
}

TEST(ReconstructorTest, ARestingCameraUpdatesNoSeeds) {
  for (const float min_move : {0.0F, 0.04F}) {
    Options options = TestOptions();
    options.min_move = min_move;
    Reconstructor reconstructor(options, NearFar());
    for (int i = 0; i < 10; ++i) reconstructor.AddFrame(PlaneFrames()[i]);
    const std::int64_t before = reconstructor.statistics().updates.total();
    const auto live = static_cast<std::int64_t>(reconstructor.live_seeds());
    ASSERT_GT(live, 1000);
    reconstructor.AddFrame(PlaneFrames()[9]);
    EXPECT_EQ(reconstructor.statistics().updates.total() - before, min_move == 0 ? live : 0);
  }
}

TEST(ReconstructorTest, SeedsThatWentOutOfViewMakeRoomThoughTheCameraHardlyMoves) {
  Options options = TestOptions();
  options.max_unseen = 5;
  options.plant_every = 3;
  Reconstructor reconstructor(options, NearFar());
  for (const PosedFrame& frame : PlaneFrames()) reconstructor.AddFrame(frame);
  ASSERT_GT(reconstructor.live_seeds(), 0.95 * options.max_seeds) << "no room for others";
  const Rigid3d about = {Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                         {0, 0, 0}};
  for (int i = 0; i < (kMostLeftOut + 1) * options.max_unseen; ++i) {
    PosedFrame away = PlaneFrames().back();
    away.cam_from_world = about * away.cam_from_world;
    reconstructor.AddFrame(away);
  }
  EXPECT_GT(reconstructor.statistics().rejected_unseen, options.max_seeds / 2);
}

TEST(ReconstructorTest, ABlackPictureDoesNoHarm) {
  std::vector<PosedFrame> frames = PlaneFrames();
  auto black = std::make_shared<Picture>();
  black->grey = Image<std::uint8_t>(frames[0].camera.width, frames[0].camera.height);
  frames[6].picture = black;
  frames[7].picture = black;
  const Result r = Reconstruct(TestOptions(), NearFar(), frames);
  EXPECT_GT(r.points.size(), 1000U);
  EXPECT_EQ(r.statistics.rejected_outlier, 0);
}

TEST(ReconstructorTest, AFrameThatLooksAwayDoesNoHarm) {
  std::vector<PosedFrame> frames = PlaneFrames();
  const Eigen::Matrix3d about =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix();
  frames[6].cam_from_world = Rigid3d{about, {0, 0, 0}} * frames[6].cam_from_world;
  Options options = TestOptions();
  Reconstructor reconstructor(options, NearFar());
  for (int i = 0; i < 6; ++i) reconstructor.AddFrame(frames[i]);
  const auto before = reconstructor.statistics().updates;
  const auto points = reconstructor.AddFrame(frames[6]).size();
  const auto after = reconstructor.statistics().updates;
  EXPECT_EQ(points, 0U);
  ASSERT_GT(after.total(), before.total());
  EXPECT_EQ(after.total() - before.total(), after.out_of_view - before.out_of_view);
  for (int i = 7; i < kFrames; ++i) reconstructor.AddFrame(frames[i]);
  EXPECT_GT(reconstructor.points().size(), 1000U);
}

TEST(ReconstructorTest, WrongSizesAndOptionsAreRefused) {
  PosedFrame frame = PlaneFrames()[0];
  frame.camera.width += 1;
  Reconstructor reconstructor(TestOptions(), NearFar());
  EXPECT_THROW(reconstructor.AddFrame(frame), std::invalid_argument);
  Options options = TestOptions();
  options.prior_a = 0;
  EXPECT_THROW(Reconstructor(options, NearFar()), std::invalid_argument);
  EXPECT_THROW(Reconstructor(TestOptions(), SceneRange{}), std::invalid_argument);
}

enum class Step { kSetFrame, kUpdate, kPlant };

// The CPU, but that one of the steps fails in a frame from some number on, as a GPU that is lost.
class FailingBackend final : public Backend {
 public:
  FailingBackend(const Options& options, Step step, int frames_before)
      : cpu_(MakeCpuBackend(options)), step_(step), frames_left_(frames_before + 1) {}

  std::string name() const override { return "failing"; }
  std::size_t capacity() const override { return cpu_->capacity(); }
  void SetFrame(std::span<const ImageView<std::uint8_t>> pyramid) override {
    --frames_left_;
    FailIn(Step::kSetFrame);
    cpu_->SetFrame(pyramid);
  }
  UpdateStatistics Update(std::span<const SeedGroup> groups, CameraModel model) override {
    FailIn(Step::kUpdate);
    return cpu_->Update(groups, model);
  }
  std::span<const EndedSeed> TakeEnded() override { return cpu_->TakeEnded(); }
  void Compact() override { cpu_->Compact(); }
  std::vector<std::size_t> Plant(const Planting& planting) override {
    FailIn(Step::kPlant);
    return cpu_->Plant(planting);
  }
  void ForgetPoints() override { cpu_->ForgetPoints(); }
  std::vector<SeedState> Read(std::size_t begin, std::size_t end, std::size_t step) override {
    return cpu_->Read(begin, end, step);
  }
  std::vector<std::uint8_t> ReadPatches(std::size_t begin, std::size_t end) override {
    return cpu_->ReadPatches(begin, end);
  }

 private:
  void FailIn(Step step) const {
    if (step == step_ && frames_left_ <= 0) throw DeviceError("GPU: it is gone");
  }

  std::unique_ptr<Backend> cpu_;
  Step step_;
  int frames_left_;
};

TEST(ReconstructorTest, WhereTheDeviceIsLostTheCpuGoesOn) {
  constexpr int kLostAt = 21, kAll = 60;
  const std::vector<PosedFrame> frames = PlaneScene().Render(SidewaysPath(kAll));
  Options options = TestOptions();
  options.backend = BackendChoice::kAuto;
  options.plant_every = 1;
  for (const Step step : {Step::kSetFrame, Step::kUpdate, Step::kPlant}) {
    Reconstructor whole(options, NearFar());
    Reconstructor reconstructor(
        options, NearFar(), std::make_unique<FailingBackend>(options, step, kLostAt));
    std::size_t before = 0;
    for (int f = 0; f < kAll; ++f) {
      const PosedFrame& frame = frames[static_cast<std::size_t>(f)];
      const std::size_t added = reconstructor.AddFrame(frame).size();
      if (f <= kLostAt) whole.AddFrame(frame);
      if (f + 1 == kLostAt) before = reconstructor.points().size();
      if (f != kLostAt) continue;
      EXPECT_EQ(reconstructor.points().size(), before + added) << "what there is, stays";
      EXPECT_EQ(reconstructor.live_seeds(), 0U);
      // Planting comes last: the frame's points are there already.
      const bool planting = step == Step::kPlant;
      EXPECT_TRUE(!planting || Identical(reconstructor.points(), whole.points()));
      EXPECT_TRUE(planting || added == 0);
    }
    EXPECT_GT(before, 0U);
    EXPECT_TRUE(reconstructor.backend_name().starts_with("CPU"));
    EXPECT_GT(reconstructor.live_seeds(), 0U) << "seeds are planted anew";
    EXPECT_GT(reconstructor.points().size(), before);
  }
}

TEST(ReconstructorTest, WhereTheGpuWasAskedForItsLossIsAnError) {
  constexpr int kLostAt = 20;
  Options options = TestOptions();
  Reconstructor reconstructor(
      options, NearFar(), std::make_unique<FailingBackend>(options, Step::kUpdate, kLostAt));
  for (int f = 0; f < kLostAt; ++f) {
    reconstructor.AddFrame(PlaneFrames()[static_cast<std::size_t>(f)]);
  }
  const std::size_t before = reconstructor.points().size();
  EXPECT_THROW(reconstructor.AddFrame(PlaneFrames()[kLostAt]), DeviceError);
  EXPECT_EQ(reconstructor.TakePoints().size(), before);
}

TEST(ReconstructorTest, TheGpuGivesTheSameCloud) {
  const CudaDevices found = FindCudaDevices();
  if (found.devices.empty()) GTEST_SKIP() << found.trouble;
  Options options = TestOptions();
  options.min_move = 0.1F;  // frames are left out
  const Result cpu = Reconstruct(options, NearFar(), PlaneFrames());
  options.backend = BackendChoice::kCuda;
  const Result gpu = Reconstruct(options, NearFar(), PlaneFrames());
  EXPECT_GT(cpu.points.size(), 300U);
  EXPECT_TRUE(Identical(cpu.points, gpu.points));
}

// Half of the plane has no texture, only noise that differs from frame to frame.
struct HalfPlain {
  std::size_t points = 0;    // that come from the plain half
  std::size_t textured = 0;  // that come from the other half
  std::size_t planted = 0;   // upper bound: all seeds
};

HalfPlain RunHalfPlain(Options options) {
  PlaneScene scene;
  scene.plain_left = 0.05;
  scene.noise = 4;
  options.max_seeds = 6000;
  options.seed_spacing_px = 2;
  options.min_patch_stddev = 0;  // seeds everywhere: the posterior has to tell
  options.threads = 2;
  options.search = Search::kWindow;
  const Result r = Reconstruct(options, NearFar(), scene.Render(SidewaysPath(60)));
  HalfPlain result;
  result.planted = static_cast<std::size_t>(r.statistics.seeds_spawned);
  for (const Point& p : r.points) {
    // A patch near the edge reaches over it.
    if (p.position.x() > 0.05F + 0.03F) ++result.textured;
    if (p.position.x() > 0.05F - 0.03F) continue;
    ++result.points;
  }
  return result;
}

TEST(ReconstructorTest, NoPointsWhereThereIsNoTexture) {
  const HalfPlain ours = RunHalfPlain(DefaultOptions());
  // At this small picture size the preset's threshold takes more frames than there are here.
  Options as_published = PaperOptions();
  as_published.epsilon_range = 0.01F;
  const HalfPlain paper = RunHalfPlain(as_published);
  EXPECT_GT(ours.textured, 300U) << "something must converge at all";
  EXPECT_GT(paper.textured, 300U);
  RecordProperty("default_textured_points", static_cast<int>(ours.textured));
  RecordProperty("default_false_points", static_cast<int>(ours.points));
  RecordProperty("paper_false_points", static_cast<int>(paper.points));
  ASSERT_GT(ours.planted, 3000U);
  EXPECT_LE(static_cast<double>(ours.points), 0.01 * static_cast<double>(ours.planted));
  EXPECT_GT(paper.points, ours.points);
}

TEST(ReconstructorTest, APlainWallGivesNothing) {
  PlaneScene scene;
  scene.contrast = 0;
  scene.noise = 2;
  const Result r = Reconstruct(TestOptions(), NearFar(), scene.Render(SidewaysPath(20)));
  EXPECT_EQ(r.points.size(), 0U);
}

}  // namespace
}  // namespace livemvs
