#include "livemvs/synth/sequence.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace livemvs {
namespace {

SequenceOptions SmallFilm() {
  SequenceOptions options;
  options.path = DefaultPath("plane");
  options.path.frames = 4;
  options.camera = SyntheticCamera(64, 48);
  return options;
}

double MeanGrey(const SyntheticFrame& frame) {
  const auto& grey = frame.frame.picture->grey;
  double sum = 0;
  for (int y = 0; y < grey.height(); ++y) {
    for (int x = 0; x < grey.width(); ++x) sum += grey(x, y);
  }
  return sum / (grey.width() * grey.height());
}

TEST(Sequence, FramesCarryPosesTimesAndTruth) {
  const SyntheticScene scene({.name = "plane"});
  const SequenceOptions options = SmallFilm();
  const auto poses = MakePath(options.path);
  const auto frames = RenderSequence(scene, options);
  ASSERT_EQ(frames.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(frames[i].frame.index, i);
    EXPECT_DOUBLE_EQ(frames[i].frame.timestamp, i / 30.0);
    EXPECT_EQ(frames[i].frame.cam_from_world.rotation, poses[i].rotation);
    EXPECT_EQ(frames[i].frame.camera.width, 64);
    EXPECT_EQ(frames[i].frame.picture->width(), 64);
    EXPECT_GT(frames[i].z_depth(32, 24), 0.5f);
  }
}

TEST(Sequence, DepthDoesNotDependOnBlurNoiseOrExposure) {
  const SyntheticScene scene({.name = "plane"});
  SequenceOptions options = SmallFilm();
  const SyntheticFrame plain = RenderSequenceFrame(scene, options, 2);
  options.blur = 0.5;
  options.noise_sigma = 2;
  options.exposure_variation = 0.3;
  const SyntheticFrame other = RenderSequenceFrame(scene, options, 2);
  EXPECT_EQ(plain.z_depth(10, 10), other.z_depth(10, 10));
  options.ground_truth = false;
  EXPECT_TRUE(RenderSequenceFrame(scene, options, 2).z_depth.empty());
}

TEST(Sequence, ExposureComesAndGoes) {
  const SyntheticScene scene({.name = "plane"});
  SequenceOptions options = SmallFilm();
  options.path.frames = 120;
  options.path.arc_deg = 0;
  options.path.wobble = 0;
  options.exposure_variation = 0.4;
  EXPECT_GT(MeanGrey(RenderSequenceFrame(scene, options, 30)),
            1.2 * MeanGrey(RenderSequenceFrame(scene, options, 90)));
}

TEST(Sequence, RejectsNonsense) {
  const SyntheticScene scene({.name = "plane"});
  SequenceOptions options = SmallFilm();
  options.blur = 2;
  EXPECT_THROW(RenderSequence(scene, options), std::invalid_argument);
  options = SmallFilm();
  options.path.frames = -3;
  EXPECT_THROW(RenderSequence(scene, options), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
