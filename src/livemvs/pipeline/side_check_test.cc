// Whether a patch matches as a whole, or only on one side of an edge.

#include "livemvs/pipeline/side_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "livemvs/pipeline/pyramid.h"
#include "livemvs/reference/side_check.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

PatchValues Noise(unsigned seed, float amplitude) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(100, amplitude);
  PatchValues values;
  for (float& v : values) v = normal(random);
  return values;
}

// `window` with the columns from `first` on of `other`.
PatchValues WithColumnsOf(PatchValues window, const PatchValues& other, int first) {
  for (int k = 0; k < kPatchPixels; ++k) {
    if (k % kPatchSize >= first) window[k] = other[k];
  }
  return window;
}

PatchValues Turned(const PatchValues& values) {
  PatchValues turned;
  for (int k = 0; k < kPatchPixels; ++k) {
    turned[k] = values[k % kPatchSize * kPatchSize + k / kPatchSize];
  }
  return turned;
}

TEST(LeastSideNcc, IsOneForTheSamePatchInOtherLight) {
  const PatchValues patch = Noise(1, 30);
  PatchValues brighter = patch;
  for (float& v : brighter) v = 0.7F * v + 60;
  EXPECT_NEAR(LeastSideNcc(patch, brighter, 4), 1, 1e-4);
  for (float& v : brighter) v = 250 - v;
  EXPECT_NEAR(LeastSideNcc(patch, brighter, 4), -1, 1e-4);
}

TEST(LeastSideNcc, IsLowWhereOneHalfShowsSomethingElse) {
  const PatchValues patch = Noise(1, 30);
  for (unsigned seed = 2; seed < 20; ++seed) {
    const PatchValues other = WithColumnsOf(patch, Noise(seed, 30), 3);
    const float least = LeastSideNcc(patch, other, 4);
    EXPECT_LT(least, 0.9F);
    // The same for rows; and whichever of the two comes first.
    EXPECT_NEAR(LeastSideNcc(Turned(patch), Turned(other), 4), least, 1e-5);
    EXPECT_NEAR(LeastSideNcc(other, patch, 4), least, 1e-5);
  }
}

TEST(LeastSideNcc, AsksHalvesThatHaveTextureOnly) {
  // The left half has texture; the right one is plain but for noise, in both pictures.
  const PatchValues patch = WithColumnsOf(Noise(1, 30), Noise(2, 2), 2);
  const PatchValues window = WithColumnsOf(Noise(1, 30), Noise(3, 2), 2);
  EXPECT_GT(LeastSideNcc(patch, window, 4), 0.8F);
  EXPECT_LT(LeastSideNcc(patch, window, 0.1F), 0.8F) << "less noise makes it texture";
  PatchValues plain;
  plain.fill(100);
  EXPECT_EQ(LeastSideNcc(plain, patch, 0), 1);
  EXPECT_NEAR(LeastSideNcc(patch, plain, 4), 0, 1e-5) << "a plain window matches nothing";
}

// Two frames at a level of their pyramids, and seeds of the first whose depths are known.
class TwoViews {
 public:
  TwoViews(std::array<PosedFrame, 2> frames, const Options& options, int level = 0)
      : frames_(std::move(frames)), options_(options), level_(level) {
    for (int i = 0; i < 2; ++i) pyramids_[i].Build(frames_[i].picture->grey, level + 1);
  }

  // Of a pixel of the level.
  EndedSeed SeedAt(int x, int y, double z_depth) const {
    const Eigen::Vector3d ray = RayOf(x, y);
    const auto along = static_cast<float>(z_depth * ray.norm());
    EndedSeed ended = {};
    SeedState& seed = ended.seed;
    seed.bearing_x = static_cast<float>(ray.x());
    seed.bearing_y = static_cast<float>(ray.y());
    const bool depth = options_.coordinate == DepthCoordinate::kDepth;
    const float near = 0.4F, far = 3, c = depth ? along : 1 / along;
    seed.interval = depth ? Interval<float>{near, far} : Interval<float>{1 / near, 1 / far};
    seed.posterior.mu = (c - seed.interval.c0) / (seed.interval.c1 - seed.interval.c0);
    const ImageView<std::uint8_t>& grey = pyramids_[0].levels()[level_];
    for (int k = 0; k < kPatchPixels; ++k) {
      ended.patch[k] = grey(x + k % kPatchSize - kPatchRadius, y + k / kPatchSize - kPatchRadius);
    }
    return ended;
  }

  // The first camera's, with z = 1.
  Eigen::Vector3d RayOf(int x, int y) const {
    return *Projector(AtLevel(frames_[0].camera, level_)).Unproject(Eigen::Vector2d(x, y));
  }

  bool Passes(const EndedSeed& ended) const {
    const Projector projector(frames_[1].camera);
    const SideCheck check(options_, frames_[1].cam_from_world, projector, pyramids_[1].levels());
    return check.Passes({0,
                         1,
                         1,
                         frames_[0].index,
                         level_,
                         AtLevel(frames_[0].camera, level_),
                         frames_[0].cam_from_world,
                         Eigen::Vector3d::Zero()},
                        ended);
  }

  bool ReferencePasses(const EndedSeed& ended) const {
    reference::Seed seed;
    seed.camera = AtLevel(frames_[0].camera, level_);
    seed.cam_from_world = frames_[0].cam_from_world;
    seed.bearing_x = ended.seed.bearing_x;
    seed.bearing_y = ended.seed.bearing_y;
    seed.interval = {ended.seed.interval.c0, ended.seed.interval.c1};
    seed.posterior.mu = ended.seed.posterior.mu;
    std::copy(std::begin(ended.patch), std::end(ended.patch), seed.patch.begin());
    return SidesMatch(options_,
                      seed,
                      {pyramids_[1].levels()[level_],
                       Projector(AtLevel(frames_[1].camera, level_)),
                       frames_[1].cam_from_world,
                       true,
                       level_});
  }

 private:
  std::array<PosedFrame, 2> frames_;
  std::array<Pyramid, 2> pyramids_;
  Options options_;
  int level_;
};

// A camera moves to the left before two textured planes that face it: the left part of the picture
// moves by kNear pixels from the first frame to the second, the right part by kFar.
constexpr int kNear = 8, kFar = 3, kEdge = 40, kWidth = 80;
constexpr double kFocal = 100, kStep = 0.08;

PosedFrame PlanesFrame(int index) {
  constexpr int kHeight = 60;
  std::mt19937 random(11);
  std::uniform_int_distribution<int> grey(20, 230);
  Image<std::uint8_t> near(kWidth, kHeight), far(kWidth, kHeight), picture(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      near(x, y) = static_cast<std::uint8_t>(grey(random));
      far(x, y) = static_cast<std::uint8_t>(grey(random));
    }
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int at_near = x - index * kNear, at_far = x - index * kFar;
      const bool on_near = at_near < kEdge;
      picture(x, y) = on_near ? near(std::max(at_near, 0), y) : far(at_far, y);
    }
  }
  PosedFrame frame;
  frame.index = index;
  frame.name = "two planes";
  frame.camera = {CameraModel::kPinhole, kWidth, kHeight, kFocal, kFocal, 39.5, 29.5, {}};
  frame.cam_from_world.translation.x() = index * kStep;
  const auto held = std::make_shared<Picture>();
  held->grey = std::move(picture);
  frame.picture = held;
  return frame;
}

class TwoPlanes : public TwoViews {
 public:
  explicit TwoPlanes(const Options& options = Options())
      : TwoViews({PlanesFrame(0), PlanesFrame(1)}, options) {}

  // The seed of a pixel of the first frame with the depth of the near plane.
  EndedSeed NearSeed(int x, int y) const { return SeedAt(x, y, kFocal * kStep / kNear); }
};

TEST(SideCheck, LetsNoSeedPassWhoseOtherHalfIsOfAnotherSurface) {
  const TwoPlanes scene;
  int inside = 0, beyond = 0;
  const int rows = 40;
  for (int y = 10; y < 10 + rows; ++y) {
    // Patches that are all on the near plane, and those whose middle is one pixel beyond its edge.
    inside += scene.Passes(scene.NearSeed(kEdge - 3, y));
    beyond += scene.Passes(scene.NearSeed(kEdge + 1, y));
  }
  EXPECT_EQ(inside, rows);
  EXPECT_LT(beyond, rows / 10);
}

TEST(SideCheck, AgreesWithTheReference) {
  const TwoPlanes scene;
  int agree = 0, all = 0, pass = 0;
  for (int y = 10; y < 50; ++y) {
    for (int x = kEdge - 6; x < kEdge + 4; ++x) {
      const EndedSeed seed = scene.NearSeed(x, y);
      const bool passes = scene.Passes(seed);
      agree += passes == scene.ReferencePasses(seed);
      pass += passes;
      ++all;
    }
  }
  EXPECT_GT(pass, all / 4);
  EXPECT_LT(pass, 3 * all / 4);
  EXPECT_GE(agree, all - all / 100);
}

TEST(SideCheck, AsksNothingWhereItIsOffOrCannotSee) {
  const TwoPlanes scene;
  const EndedSeed beyond = scene.NearSeed(kEdge + 1, 30);
  ASSERT_FALSE(scene.Passes(beyond));
  Options off;
  off.min_side_ncc = -1;
  EXPECT_TRUE(TwoPlanes(off).Passes(beyond));
  EXPECT_TRUE(TwoPlanes(off).ReferencePasses(beyond));
  // Its patch would reach beyond the picture's right side.
  EXPECT_TRUE(scene.Passes(scene.NearSeed(71, 30)));
}

struct ViewCase {
  const char* name;
  CameraModel model = CameraModel::kPinhole;
  std::array<double, 8> distortion{};
  double roll_deg = 0;
  double nearer = 0;  // [scene], of 1
  int level = 0;
  bool mirrored = false;
  DepthCoordinate coordinate = DepthCoordinate::kInverseDepth;
};

class SideCheckViews : public testing::TestWithParam<ViewCase> {};

TEST_P(SideCheckViews, FindsThePatchAndAgreesWithTheReference) {
  const ViewCase& c = GetParam();
  const int size = 1 << c.level;
  const double fy = (c.mirrored ? -1 : 1) * 192.0 * size;
  const Camera camera = {
      c.model, 200 * size, 150 * size, 190.0 * size, fy, 98.5 * size, 76.25 * size, c.distortion};
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(c.roll_deg * M_PI / 180, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Rigid3d pose = {rotation, -(rotation * Eigen::Vector3d(0.07, 0.03, c.nearer))};
  Options options;
  options.coordinate = c.coordinate;
  testing_support::PlaneScene scene;
  scene.camera = camera;
  const TwoViews views({scene.Render(Rigid3d{}, 0), scene.Render(pose, 1)}, options, c.level);
  // z = 1 + 0.3 x + 0.2 y, the first camera at the origin.
  const auto depth_of = [&](int x, int y) {
    const Eigen::Vector3d ray = views.RayOf(x, y);
    return 1 / (1 - 0.3 * ray.x() - 0.2 * ray.y());
  };
  int all = 0, pass = 0, pass_elsewhere = 0, agree = 0;
  for (int y = 40; y < 110; y += 3) {
    for (int x = 50; x < 150; x += 3) {
      const EndedSeed right = views.SeedAt(x, y, depth_of(x, y));
      const EndedSeed wrong = views.SeedAt(x, y, 1.4 * depth_of(x, y));
      pass += views.Passes(right);
      pass_elsewhere += views.Passes(wrong);
      agree += (views.Passes(right) == views.ReferencePasses(right)) +
               (views.Passes(wrong) == views.ReferencePasses(wrong));
      ++all;
    }
  }
  EXPECT_GT(pass, 0.95 * all);
  EXPECT_LT(pass_elsewhere, 0.3 * all);
  EXPECT_GE(agree, 2 * 0.99 * all);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    SideCheckViews,
    testing::Values(ViewCase{.name = "Sideways"},
                    ViewCase{.name = "Rolled", .roll_deg = 30},
                    ViewCase{.name = "RolledBack", .roll_deg = -30},
                    ViewCase{.name = "Nearer", .roll_deg = 10, .nearer = 0.3},
                    ViewCase{.name = "Further", .roll_deg = -20, .nearer = -0.3},
                    ViewCase{.name = "Mirrored", .roll_deg = 25, .mirrored = true},
                    ViewCase{.name = "Level1", .roll_deg = 15, .nearer = 0.1, .level = 1},
                    ViewCase{.name = "Level2", .roll_deg = 15, .nearer = 0.1, .level = 2},
                    ViewCase{
                        .name = "Depth", .roll_deg = 15, .coordinate = DepthCoordinate::kDepth},
                    ViewCase{.name = "Barrel",
                             .model = CameraModel::kBrownConrady,
                             .distortion = {-0.3, 0.1, 0.002, -0.001},
                             .roll_deg = 20},
                    ViewCase{.name = "Fisheye",
                             .model = CameraModel::kKannalaBrandt,
                             .distortion = {-0.05, 0.01},
                             .roll_deg = 20}),
    [](const auto& view) { return std::string(view.param.name); });

TEST(SideCheck, JudgesNothingAtTheBorder) {
  const TwoPlanes scene;
  int judged = 0;
  for (int x = 40; x < 78; ++x) {
    for (float nudge = -4e-6F; nudge <= 4e-6F; nudge += 1e-6F) {
      EndedSeed seed = scene.NearSeed(x, 30);
      seed.seed.bearing_x += nudge;
      // Its patch would reach to the last pixel but one, in a picture of 80.
      if (x + kNear + kPatchRadius > 78) {
        EXPECT_TRUE(scene.Passes(seed)) << x;
      } else {
        judged += !scene.Passes(seed);
      }
    }
  }
  EXPECT_GT(judged, 100);
}

}  // namespace
}  // namespace livemvs
