#include "livemvs/synth/labels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

namespace livemvs {
namespace {

const SyntheticScene& Hazards() {
  static const SyntheticScene scene({.name = "hazards", .shadows = false});
  return scene;
}

SequenceOptions Small() {
  SequenceOptions options;
  options.path = DefaultPath("hazards");
  options.path.frames = 120;
  options.camera = SyntheticCamera(320, 240);
  options.samples_per_pixel = 1;
  return options;
}

// A frame made by hand of materials of the hazards: 12 x 8 pixels, the left half 1 m, the right
// half 2 m away, the last column empty.
struct HandMade {
  Image<float> z_depth{12, 8};
  Image<std::uint8_t> material{12, 8};

  explicit HandMade(std::uint8_t left, std::uint8_t right) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 12; ++x) {
        z_depth(x, y) = x < 6 ? 1.F : x < 11 ? 2.F : 0.F;
        material(x, y) = x < 6 ? left : x < 11 ? right : RenderedFrame::kNoMaterial;
      }
    }
  }
};

std::uint8_t MaterialNamed(const std::string& name) {
  const auto& materials = Hazards().materials();
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (materials[i].name == name) return static_cast<std::uint8_t>(i);
  }
  ADD_FAILURE() << name;
  return 0;
}

TEST(Labels, OfAHandMadeFrame) {
  const HandMade frame(MaterialNamed("plain wall"), MaterialNamed("striped wall"));
  LabelOptions options;
  options.edge_radius = 1;
  const Image<std::uint8_t> labels = LabelPixels(Hazards(), frame.z_depth, frame.material, options);
  // The jumps lie between columns 5 and 6 and between 10 and 11: two columns on each side.
  const int edge = kLabelOccludingEdge;
  const int expected[12] = {kLabelTextureless,
                            kLabelTextureless,
                            kLabelTextureless,
                            kLabelTextureless,
                            kLabelTextureless | edge,
                            kLabelTextureless | edge,
                            kLabelRepetitive | edge,
                            kLabelRepetitive | edge,
                            kLabelRepetitive,
                            kLabelRepetitive | edge,
                            kLabelRepetitive | edge,
                            kLabelBackground | edge};
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 12; ++x) EXPECT_EQ(labels(x, y), expected[x]) << x << ' ' << y;
  }
}

TEST(Labels, GlossyAndOrdinaryMaterials) {
  const HandMade frame(MaterialNamed("glossy ball"), MaterialNamed("sheet"));
  const Image<std::uint8_t> labels = LabelPixels(Hazards(), frame.z_depth, frame.material);
  EXPECT_EQ(labels(1, 3), kLabelSpecular);
  EXPECT_EQ(labels(8, 3) & ~kLabelOccludingEdge, 0);
}

// Counts of pixels by material that have the label.
std::map<std::string, int> CountByMaterial(const SyntheticFrame& frame,
                                           const Image<std::uint8_t>& labels,
                                           unsigned label) {
  std::map<std::string, int> counts;
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      if ((labels(x, y) & label) == 0 || frame.z_depth(x, y) == 0) continue;
      ++counts[Hazards().materials()[frame.material(x, y)].name];
    }
  }
  return counts;
}

TEST(Labels, WhatTheRodsHideNextIsSoonOccluded) {
  // The camera stands before the grating and moves on to the right: columns of the picture behind
  // it disappear and others appear.
  const SequenceOptions sequence = Small();
  const SyntheticFrame frame = RenderSequenceFrame(Hazards(), sequence, 60);
  LabelOptions options;
  options.following_frames = 6;
  const Image<std::uint8_t> labels = LabelSequenceFrame(Hazards(), sequence, frame, options);
  const auto soon = CountByMaterial(frame, labels, kLabelSoonOccluded);
  const auto all = CountByMaterial(frame, labels, 0xFF);
  ASSERT_TRUE(soon.contains("picture"));
  EXPECT_GT(soon.at("picture"), 50);
  // Nothing stands before the stone, whatever the camera does.
  EXPECT_FALSE(soon.contains("stone") && soon.at("stone") > 10);

  // By definition: follow some of the picture's pixels by hand.
  int compared = 0;
  const Projector projector(sequence.camera);
  for (int y = 0; y < 240; y += 2) {
    for (int x = 0; x < 320; x += 2) {
      if (frame.z_depth(x, y) == 0) continue;
      if (Hazards().materials()[frame.material(x, y)].name != "picture") continue;
      const Eigen::Vector3d place =
          frame.frame.cam_from_world.Inverse() *
          (static_cast<double>(frame.z_depth(x, y)) * *projector.Unproject({x, y}));
      int hidden = 0;
      for (int i = 61; i <= 66; ++i) {
        const Eigen::Vector3d eye = PoseAt(sequence.path, i).Center();
        SyntheticScene::Hit hit;
        ASSERT_TRUE(Hazards().Intersect(eye, place - eye, &hit));
        hidden += hit.distance < 0.998;
      }
      EXPECT_EQ((labels(x, y) & kLabelSoonOccluded) != 0, hidden > 3) << x << ' ' << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 100);
  EXPECT_LT(soon.at("picture"), 3 * compared);
}

TEST(Labels, TheLastFrameHasNothingToCome) {
  const SequenceOptions sequence = Small();
  const int last = sequence.path.frames - 1;
  const SyntheticFrame frame = RenderSequenceFrame(Hazards(), sequence, last);
  const Image<std::uint8_t> labels = LabelSequenceFrame(Hazards(), sequence, frame);
  EXPECT_TRUE(CountByMaterial(frame, labels, kLabelSoonOccluded).empty());
  // Each thing is there to be judged, with its label.
  EXPECT_GT(CountByMaterial(frame, labels, kLabelTextureless)["plain wall"], 300);
  EXPECT_GT(CountByMaterial(frame, labels, kLabelRepetitive)["striped wall"], 300);
  EXPECT_GT(CountByMaterial(frame, labels, kLabelSpecular)["glossy ball"], 100);
  EXPECT_GT(CountByMaterial(frame, labels, kLabelOccludingEdge)["sheet"], 100);
}

TEST(Labels, RejectsNonsense) {
  const HandMade frame(0, 0);
  for (const LabelOptions& options : {LabelOptions{.edge_radius = -1},
                                      LabelOptions{.edge_jump = 0},
                                      LabelOptions{.following_frames = -1},
                                      LabelOptions{.frame_step = 0},
                                      LabelOptions{.occluded_share = NAN}}) {
    EXPECT_THROW(LabelPixels(Hazards(), frame.z_depth, frame.material, options),
                 std::invalid_argument);
  }
}

}  // namespace
}  // namespace livemvs
