#include "livemvs/stream/point_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "livemvs/core/lean.h"
#include "livemvs/stream/bytes.h"

namespace livemvs {
namespace {

// Quantisation, see EncodePoints().
constexpr float kLengthError = 0.022F;                                 // half of 1/16 octave
constexpr float kNormalError = 1.0F * static_cast<float>(M_PI) / 180;  // [rad]
constexpr float kLeanError = 7.5F * static_cast<float>(M_PI) / 180;    // [rad]
constexpr float kRatioError = 0.5F / 255 + 1e-6F;
constexpr float kFloatRounding = 4e-7F;  // relative to the largest coordinate

PointCloud RandomPoints(std::size_t count, float extent, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  PointCloud points(count);
  for (Point& p : points) {
    p.position = extent / 2 * Eigen::Vector3f(unit(random), unit(random), unit(random));
    p.normal = Eigen::Vector3f(unit(random), unit(random), unit(random)).normalized();
    // Some along the z axis, where directions across the normal are hardest to tell.
    if (random() % 4 == 0) p.normal = {0.02F * unit(random), 0.02F * unit(random), p.normal.z()};
    p.normal.normalize();
    p.color = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 3};
    p.sigma = 1e-3F * std::exp2(3 * unit(random));
    p.footprint = 2e-3F * std::exp2(2 * unit(random));
    p.inlier_ratio = std::abs(unit(random));
    p.views = static_cast<std::uint16_t>(random() % 256);
    p.level = static_cast<std::uint8_t>(random() % 8);
    p.lean = static_cast<std::uint8_t>(random() % (kLeanNowhere + 1));
  }
  return points;
}

void ExpectClose(const Point& a, const Point& b, float position_error) {
  EXPECT_LT((a.position - b.position).cwiseAbs().maxCoeff(), position_error);
  EXPECT_LT(std::acos(std::clamp(a.normal.dot(b.normal), -1.0F, 1.0F)), kNormalError);
  EXPECT_EQ(a.color, b.color);
  EXPECT_NEAR(a.inlier_ratio, b.inlier_ratio, kRatioError);
  EXPECT_NEAR(a.sigma, b.sigma, kLengthError * a.sigma);
  EXPECT_NEAR(a.footprint, b.footprint, kLengthError * a.footprint);
  EXPECT_EQ(a.views, b.views);
  EXPECT_EQ(a.level, b.level);
  if (Leans(a.lean)) {
    // Half a step of the code, and what the normal is off by.
    ASSERT_TRUE(Leans(b.lean));
    const float aligned = LeanDirection(a.normal, a.lean).dot(LeanDirection(b.normal, b.lean));
    EXPECT_GT(aligned, std::cos(kLeanError));
  } else {
    EXPECT_EQ(a.lean, b.lean);
  }
}

TEST(PointCodec, PointsComeBackWithinTheQuantisation) {
  const PointCloud points = RandomPoints(1000, 2, 1);
  const auto back = DecodePoints(EncodePoints(42, 7, points));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->frame, 42);
  EXPECT_EQ(back->first_id, 7U);
  ASSERT_EQ(back->points.size(), points.size());
  const float error = 2.0F / 131070 + 2 * kFloatRounding;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ExpectClose(points[i], back->points[i], error);
    EXPECT_EQ(back->points[i].frame, 42);
  }
}

TEST(PointCodec, ARecordTakesSixteenBytesAPoint) {
  EXPECT_EQ(EncodePoints(0, 0, RandomPoints(100, 1, 2)).size(), 48 + 100 * kPointBytes);
}

TEST(PointCodec, AxesNormalsAndZerosAreExact) {
  PointCloud points;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0F, 1.0F}) {
      Point p;
      p.normal[axis] = sign;
      points.push_back(p);
    }
  }
  points.push_back(Point{});  // no normal
  const auto back = DecodePoints(EncodePoints(0, 0, points));
  ASSERT_TRUE(back);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(back->points[i].normal, points[i].normal) << i;
    EXPECT_EQ(back->points[i].position, points[i].position) << i;
    EXPECT_EQ(back->points[i].sigma, 0) << i;
  }
}

TEST(PointCodec, RefinedAndRemovedPointsNameTheirIds) {
  const PointCloud points = RandomPoints(3, 1, 3);
  const std::vector<std::uint32_t> ids = {5, 1, 4'000'000'000};
  const Bytes bytes = EncodeRefinedPoints(9, ids, points);
  const auto back = DecodeRefinedPoints(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->ids, ids);
  EXPECT_EQ(back->frame, 9);
  EXPECT_EQ(back->points.size(), 3U);
  EXPECT_EQ(DecodeRemovedPoints(EncodeRemovedPoints(ids)), ids);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(DecodeRefinedPoints(ByteSpan(bytes).first(n))) << n;
  }
}

TEST(PointCodec, MalformedPayloadsAreRefused) {
  const Bytes good = EncodePoints(0, 0, RandomPoints(4, 1, 4));
  for (std::size_t n = 0; n < good.size(); ++n) {
    EXPECT_FALSE(DecodePoints(ByteSpan(good).first(n))) << n;
  }
  Bytes bytes = good;
  bytes[11] = 0x7F;  // two thousand million points
  EXPECT_FALSE(DecodePoints(bytes));
  bytes = good;
  for (int i = 12; i < 16; ++i) bytes[i] = 0xFF;  // ids beyond the last
  EXPECT_FALSE(DecodePoints(bytes));
  bytes = good;
  for (int i = 28; i < 32; ++i) bytes[i] = 0xFF;  // an extent that is NaN
  EXPECT_FALSE(DecodePoints(bytes));
  EXPECT_FALSE(DecodeRemovedPoints(Bytes{255, 255, 255, 255, 0, 0, 0, 0}));
}

TEST(PointCodec, GroupsAreFineEnoughAndLoseNoPoint) {
  // A room of 100 m, known to a millimetre.
  PointCloud points = RandomPoints(200'000, 100, 5);
  for (Point& p : points) p.sigma = 1e-3F;
  std::size_t count = 0;
  for (const PointCloud& group : GroupForStream(points)) {
    count += group.size();
    EXPECT_LE(group.size(), kMaxPointsPerRecord);
    const auto back = DecodePoints(EncodePoints(0, 0, group));
    ASSERT_TRUE(back);
    const bool smallest = group.size() < 128;
    for (std::size_t i = 0; i < group.size() && !smallest; ++i) {
      const float moved = (back->points[i].position - group[i].position).cwiseAbs().maxCoeff();
      EXPECT_LE(moved, 1e-3F / 8 + 100 * kFloatRounding);
    }
  }
  EXPECT_EQ(count, points.size());
}

TEST(PointCodec, PointsThatAreNotFiniteAreLeftOut) {
  PointCloud points = RandomPoints(3, 1, 6);
  points[0].position.x() = std::numeric_limits<float>::quiet_NaN();
  points[1].sigma = std::numeric_limits<float>::infinity();
  const auto groups = GroupForStream(points);
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_EQ(groups[0].size(), 1U);
  EXPECT_TRUE(GroupForStream({}).empty());
}

}  // namespace
}  // namespace livemvs
