#include "livemvs/reference/ncc_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace livemvs::reference {
namespace {

// A frontoparallel plane at a depth of 2, seen by two cameras side by side: the pixel (x, y) of the
// first is (x - f b / Z, y) of the second. All that follows is worked out by hand from that.
constexpr int kWidth = 160, kHeight = 40;
constexpr double kFocal = 200, kPlane = 2, kBaseline = 0.2;
constexpr double kDisparity = kFocal * kBaseline / kPlane;  // 20 px

using Texture = std::function<double(double x, double y)>;  // grey level at a pixel of the first

// Not periodic: sines of incommensurable wavelengths.
double Speckle(double x, double y) {
  return 120 + 30 * std::sin(0.9 * x + 0.3 * y) + 30 * std::sin(0.47 * x - 0.8 * y + 1) +
         25 * std::sin(0.23 * x + 0.55 * y + 2) + 20 * std::sin(1.31 * x + 0.11 * y);
}

class NccCurveTest : public ::testing::Test {
 protected:
  Image<std::uint8_t> Render(const Texture& texture, double shift) const {
    Image<std::uint8_t> image(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        image(x, y) = static_cast<std::uint8_t>(std::lround(texture(x + shift, y)));
      }
    }
    return image;
  }

  NccCurve Trace(const Texture& texture, double z_min, double z_max, double max_step_px = 0.5) {
    first_ = Render(texture, 0);
    second_ = Render(texture, kDisparity);
    const Camera camera{CameraModel::kPinhole, kWidth, kHeight, kFocal, kFocal, 80, 20, {}};
    const PosedView reference{first_.view(), Projector(camera), {}};
    Rigid3d beside;
    beside.translation = {-kBaseline, 0, 0};
    neighbour_ = {second_.view(), Projector(camera), beside};
    ray_ = MakeRayPatch(reference, 80, 20);  // on the axis: depth is planar depth
    return TraceNcc(ray_, neighbour_, z_min, z_max, max_step_px);
  }

  static double DisparityAt(double depth) { return kFocal * kBaseline / depth; }

  Image<std::uint8_t> first_, second_;
  PosedView neighbour_{{}, Projector({}), {}};
  RayPatch ray_;
};

const NccMaximum& Best(const NccCurve& curve) {
  const NccMaximum* best = &curve.maxima.at(0);
  for (const NccMaximum& m : curve.maxima) {
    if (m.score > best->score) best = &m;
  }
  return *best;
}

TEST_F(NccCurveTest, BestMaximumIsTheTrueDepth) {
  const NccMaximum best = Best(Trace(Speckle, 1, 4));
  // Rounding to grey levels and the bilinear interpolation cost some hundredths of a pixel.
  EXPECT_NEAR(DisparityAt(best.depth), kDisparity, 0.05);
  EXPECT_GT(best.score, 0.99);
  // d(disparity)/dZ = f b / Z².
  EXPECT_NEAR(best.depth_per_px, kPlane * kPlane / (kFocal * kBaseline), 0.01);
}

TEST_F(NccCurveTest, ScoresArePearsonsCorrelation) {
  const NccCurve curve = Trace(Speckle, 1, 4, 0.005);
  ASSERT_EQ(curve.depths.size(), curve.scores.size());
  int compared = 0;
  for (std::size_t n = 0; n < curve.depths.size(); ++n) {
    // Only where the patch falls on whole pixels, so that nothing is interpolated.
    const double disparity = DisparityAt(curve.depths[n]);
    const int whole = static_cast<int>(std::lround(disparity));
    if (std::abs(disparity - whole) > 0.002) continue;
    double s_w = 0, s_p = 0, s_ww = 0, s_pp = 0, s_wp = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const double p = first_(80 + dx, 20 + dy), w = second_(80 + dx - whole, 20 + dy);
        s_w += w;
        s_p += p;
        s_ww += w * w;
        s_pp += p * p;
        s_wp += w * p;
      }
    }
    const double expected =
        (25 * s_wp - s_w * s_p) / std::sqrt((25 * s_ww - s_w * s_w) * (25 * s_pp - s_p * s_p));
    EXPECT_NEAR(curve.scores[n], expected, 0.01) << "disparity " << disparity;
    ++compared;
  }
  EXPECT_GE(compared, 5);
}

TEST_F(NccCurveTest, SamplesAreDenseAndAscend) {
  const NccCurve curve = Trace(Speckle, 0.5, 40);
  ASSERT_GT(curve.depths.size(), 150u);  // 80 px down to 1 px of disparity; the picture ends at 77
  for (std::size_t n = 1; n < curve.depths.size(); ++n) {
    EXPECT_GT(curve.depths[n], curve.depths[n - 1]);
    EXPECT_LE(DisparityAt(curve.depths[n - 1]) - DisparityAt(curve.depths[n]), 0.5 + 1e-9);
  }
}

TEST_F(NccCurveTest, FindsEveryPeriodOfARepetitiveTexture) {
  const auto stripes = [](double x, double y) {
    return 128 + 90 * std::sin(2 * std::numbers::pi * x / 10) + 5 * std::sin(y);
  };
  // Disparities of 40 to 10 px: maxima at 40, 30, 20 and 10, of which the ends do not count.
  const NccCurve curve = Trace(stripes, 1.0001, 3.9999);
  ASSERT_EQ(curve.maxima.size(), 2u);
  EXPECT_NEAR(DisparityAt(curve.maxima[0].depth), 30, 0.1);
  EXPECT_NEAR(DisparityAt(curve.maxima[1].depth), 20, 0.1);
}

TEST_F(NccCurveTest, NoSamplesWhereTheRayIsOutOfView) {
  // Disparities above 77 px leave the picture on its left: depths below 40/77.
  const NccCurve curve = Trace(Speckle, 0.1, 4);
  ASSERT_FALSE(curve.depths.empty());
  EXPECT_NEAR(curve.depths.front(), 40.0 / 77, 0.01);
  EXPECT_TRUE(Trace(Speckle, 0.1, 0.4).depths.empty());
}

TEST_F(NccCurveTest, NothingWithoutContrastOrBaseline) {
  EXPECT_TRUE(Trace([](double, double) { return 100.0; }, 1, 4).depths.empty());
  Trace(Speckle, 1, 4);
  neighbour_.image = first_.view();
  neighbour_.cam_from_world = {};
  EXPECT_TRUE(TraceNcc(ray_, neighbour_, 1, 4).maxima.empty());
}

TEST_F(NccCurveTest, RefusesWrongArguments) {
  Trace(Speckle, 1, 4);
  EXPECT_THROW(TraceNcc(ray_, neighbour_, 2, 2), std::invalid_argument);
  EXPECT_THROW(TraceNcc(ray_, neighbour_, 1, 2, 0), std::invalid_argument);
  EXPECT_THROW(MakeRayPatch(neighbour_, 1, 20), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs::reference
