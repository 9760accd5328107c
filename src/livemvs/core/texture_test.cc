#include "livemvs/core/texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace livemvs {
namespace {

constexpr std::ptrdiff_t kStride = 7;  // the patch lies in a wider picture
using Picture = std::array<std::uint8_t, kStride * kPatchSize>;

const std::uint8_t* CenterOf(const Picture& picture) {
  return picture.data() + kPatchRadius * kStride + kPatchRadius;
}

// Of the directions of a half turn, by the definition.
double LargestOfAllDirections(const Picture& picture) {
  std::array<double, kPatchPixels> patch{};
  for (int k = 0; k < kPatchPixels; ++k) {
    patch[k] = picture[k / kPatchSize * kStride + k % kPatchSize];
  }
  double largest = 0;
  constexpr int kDirections = 3600;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = M_PI * i / kDirections;
    const auto texture = Texture<double>(patch.data(), std::cos(angle), std::sin(angle));
    largest = std::max(largest, texture.along2);
  }
  return largest;
}

TEST(Texture, LargestIsThatOfTheBestDirection) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 100; ++trial) {
    Picture picture{};
    // From faint noise to full contrast, about an edge of some direction.
    const double contrast = std::pow(2.0, 8 * uniform(random)) - 1, angle = M_PI * uniform(random);
    for (int i = 0; i < static_cast<int>(picture.size()); ++i) {
      const auto column = i % kStride - kPatchRadius, row = i / kStride - kPatchRadius;
      const double across = std::cos(angle) * static_cast<double>(column) +
                            std::sin(angle) * static_cast<double>(row);
      const double grey = contrast * (0.5 + 0.3 * std::tanh(across) + 0.2 * uniform(random));
      picture[i] = static_cast<std::uint8_t>(grey);
    }
    const double expected = LargestOfAllDirections(picture);
    EXPECT_NEAR(LargestTexture(CenterOf(picture), kStride), expected, 2e-5 * expected + 1e-4);
  }
}

TEST(Texture, FlatPatchesAndRampsHaveNone) {
  Picture picture{};
  picture.fill(255);
  EXPECT_EQ(LargestTexture(CenterOf(picture), kStride), 0);
  // Gain and offset explain a ramp of brightness wherever it is moved.
  for (int i = 0; i < static_cast<int>(picture.size()); ++i) {
    picture[i] = static_cast<std::uint8_t>(20 + 30 * (i % kStride));
  }
  EXPECT_NEAR(LargestTexture(CenterOf(picture), kStride), 0, 0.05);
  for (int i = 0; i < static_cast<int>(picture.size()); ++i) {
    picture[i] = static_cast<std::uint8_t>(std::lround(20 * std::pow(1.4, i % kStride)));
  }
  EXPECT_NEAR(LargestTexture(CenterOf(picture), kStride), 0, 5);  // rounded grey levels
}

TEST(Texture, PatchesMatchWhereTheNoiseIsLessThanTheirTexture) {
  Options options;
  Picture picture{};
  for (int i = 0; i < static_cast<int>(picture.size()); ++i) {
    picture[i] = i % kStride < kPatchRadius ? 100 : 110;
  }
  EXPECT_TRUE(CanMatch(options, 1, CenterOf(picture), kStride));
  EXPECT_FALSE(CanMatch(options, 400, CenterOf(picture), kStride));
  picture.fill(100);
  EXPECT_FALSE(CanMatch(options, 1, CenterOf(picture), kStride));
}

// Black on one side of an edge before column `edge` of the patch, white on the other.
Picture StepAt(int edge, double noise = 0) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
  Picture picture{};
  for (int i = 0; i < static_cast<int>(picture.size()); ++i) {
    const double grey = (i % kStride < edge ? 60 : 160) + (noise > 0 ? normal(random) : 0);
    picture[i] = static_cast<std::uint8_t>(std::lround(grey));
  }
  return picture;
}

TEST(Texture, IsCentredWhereItsCentroidIsNearTheMiddle) {
  // Edges between the columns 0 and 1, ... lie 1.5 and 0.5 px from the middle.
  const bool near[] = {false, true, true, false};
  for (int edge = 1; edge < kPatchSize; ++edge) {
    EXPECT_EQ(IsCentred(1, 4, CenterOf(StepAt(edge)), kStride), near[edge - 1]) << edge;
    EXPECT_EQ(IsCentred(1, 4, CenterOf(StepAt(edge, 2)), kStride), near[edge - 1]) << edge;
    EXPECT_TRUE(IsCentred(1.6F, 4, CenterOf(StepAt(edge)), kStride)) << edge;
    EXPECT_TRUE(IsCentred(0, 4, CenterOf(StepAt(edge)), kStride)) << edge;
    const TextureMoments texture = MomentsOfTexture(4, CenterOf(StepAt(edge)), kStride);
    ASSERT_GT(texture.sum, 0);
    EXPECT_FLOAT_EQ(texture.x / texture.sum, static_cast<float>(edge) - 2.5F);
    EXPECT_NEAR(texture.y / texture.sum, 0, 1e-5F);
  }
  // Two edges balance each other, and nothing has no side.
  Picture line = StepAt(1);
  for (int i = 0; i < static_cast<int>(line.size()); ++i) {
    if (i % kStride == kPatchSize - 1) line[i] = 60;
  }
  EXPECT_TRUE(IsCentred(0.1F, 4, CenterOf(line), kStride));
  EXPECT_TRUE(IsCentred(0.1F, 4, CenterOf(StepAt(kStride)), kStride));
}

TEST(Texture, NoiseMovesNoCentroid) {
  // Faint texture at one side, noise everywhere: told that it is noise, what is left is at the
  // side.
  Picture picture = StepAt(kStride, 4);
  for (int r = 0; r < kPatchSize; ++r) picture[r * kStride] = r % 2 ? 68 : 52;
  EXPECT_TRUE(IsCentred(1.3F, 0, CenterOf(picture), kStride));
  EXPECT_FALSE(IsCentred(1.3F, 25, CenterOf(picture), kStride));
}

}  // namespace
}  // namespace livemvs
