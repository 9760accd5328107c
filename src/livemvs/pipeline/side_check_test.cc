// Whether a patch matches as a whole, or only on one side of an edge.

#include "livemvs/pipeline/side_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "livemvs/reference/side_check.h"

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

// A camera moves to the left before two textured planes that face it: the left part of the picture
// moves by kNear pixels from the first frame to the second, the right part by kFar.
class TwoPlanes {
 public:
  static constexpr int kNear = 8, kFar = 3, kEdge = 40;
  static constexpr double kFocal = 100, kStep = 0.08;

  TwoPlanes() : frames_{Frame(0), Frame(1)} {}

  const PosedFrame& frame(int i) const { return frames_[i]; }

  // The seed of a pixel of the first frame with the depth of the near plane.
  EndedSeed NearSeed(int x, int y) const {
    const float depth = kFocal * kStep / kNear;
    const Camera& camera = frames_[0].camera;
    EndedSeed ended = {};
    SeedState& seed = ended.seed;
    seed.bearing_x = static_cast<float>((x - camera.cx) / camera.fx);
    seed.bearing_y = static_cast<float>((y - camera.cy) / camera.fy);
    const float along =
        depth * std::sqrt(1 + seed.bearing_x * seed.bearing_x + seed.bearing_y * seed.bearing_y);
    seed.interval = {1 / (0.5F * along), 1 / (4 * along)};
    seed.posterior.mu = (1 / along - seed.interval.c0) / (seed.interval.c1 - seed.interval.c0);
    seed.fate = Fate::kConverged;
    for (int k = 0; k < kPatchPixels; ++k) {
      ended.patch[k] = frames_[0].picture->grey(x + k % kPatchSize - kPatchRadius,
                                                y + k / kPatchSize - kPatchRadius);
    }
    return ended;
  }

  bool Passes(const EndedSeed& seed, const Options& options = Options()) const {
    const ImageView<std::uint8_t> level = frames_[1].picture->grey.view();
    const PosedFrame& ref = frames_[0];
    SideCheck check(options, frames_[1], {&level, 1});
    return check.Passes({0, 1, 1, 0, 0, ref.camera, ref.cam_from_world, Eigen::Vector3d::Zero()},
                        seed);
  }

  bool ReferencePasses(const EndedSeed& ended, const Options& options = Options()) const {
    reference::Seed seed;
    seed.camera = frames_[0].camera;
    seed.cam_from_world = frames_[0].cam_from_world;
    seed.bearing_x = ended.seed.bearing_x;
    seed.bearing_y = ended.seed.bearing_y;
    seed.interval = {ended.seed.interval.c0, ended.seed.interval.c1};
    seed.posterior.mu = ended.seed.posterior.mu;
    std::copy(std::begin(ended.patch), std::end(ended.patch), seed.patch.begin());
    return SidesMatch(
        options,
        seed,
        {frames_[1].picture->grey.view(), Projector(frames_[1].camera), frames_[1].cam_from_world});
  }

 private:
  static constexpr int kWidth = 80, kHeight = 60;

  static PosedFrame Frame(int index) {
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

  std::array<PosedFrame, 2> frames_;
};

TEST(SideCheck, LetsNoSeedPassWhoseOtherHalfIsOfAnotherSurface) {
  const TwoPlanes scene;
  int inside = 0, beyond = 0;
  const int rows = 40;
  for (int y = 10; y < 10 + rows; ++y) {
    // Patches that are all on the near plane, and those whose middle is one pixel beyond its edge.
    inside += scene.Passes(scene.NearSeed(TwoPlanes::kEdge - 3, y));
    beyond += scene.Passes(scene.NearSeed(TwoPlanes::kEdge + 1, y));
  }
  EXPECT_EQ(inside, rows);
  EXPECT_LT(beyond, rows / 10);
}

TEST(SideCheck, AgreesWithTheReference) {
  const TwoPlanes scene;
  int agree = 0, all = 0, pass = 0;
  for (int y = 10; y < 50; ++y) {
    for (int x = TwoPlanes::kEdge - 6; x < TwoPlanes::kEdge + 4; ++x) {
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
  const EndedSeed beyond = scene.NearSeed(TwoPlanes::kEdge + 1, 30);
  ASSERT_FALSE(scene.Passes(beyond));
  Options off;
  off.min_side_ncc = -1;
  EXPECT_TRUE(scene.Passes(beyond, off));
  EXPECT_TRUE(scene.ReferencePasses(beyond, off));
  // Its patch would reach beyond the picture's right side.
  EXPECT_TRUE(scene.Passes(scene.NearSeed(71, 30)));
}

}  // namespace
}  // namespace livemvs
