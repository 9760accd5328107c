#include "livemvs/core/lean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

namespace livemvs {
namespace {

constexpr float kHalfStep = std::numbers::pi_v<float> / kLeanDirections;

Eigen::Vector3f RandomDirection(std::mt19937* random) {
  std::normal_distribution<float> normal;
  return Eigen::Vector3f(normal(*random), normal(*random), normal(*random)).normalized();
}

TEST(Lean, DecodesToWithinHalfAStep) {
  std::mt19937 random(1);
  std::set<int> codes;
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::Vector3f view = RandomDirection(&random), direction = RandomDirection(&random);
    const Eigen::Vector3f across = direction - view * view.dot(direction);
    const std::uint8_t code = LeanCode(view, 3 * direction);
    ASSERT_TRUE(Leans(code));
    codes.insert(code);
    const Eigen::Vector3f decoded = LeanDirection(view, code);
    EXPECT_NEAR(decoded.norm(), 1, 1e-3F);
    EXPECT_NEAR(decoded.dot(view), 0, 1e-3F);
    EXPECT_GT(decoded.dot(across.normalized()), std::cos(1.01F * kHalfStep));
  }
  EXPECT_EQ(codes.size(), kLeanDirections);
}

TEST(Lean, HoldsWhereTheCameraLooksAlongAnAxis) {
  for (const float sign : {-1.0F, 1.0F}) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3f view = sign * Eigen::Vector3f::Unit(axis);
      const Eigen::Vector3f across = Eigen::Vector3f::Unit((axis + 1) % 3);
      EXPECT_GT(LeanDirection(view, LeanCode(view, across)).dot(across),
                std::cos(1.01F * kHalfStep));
      EXPECT_LT(LeanDirection(view, LeanCode(view, -across)).dot(across),
                -std::cos(1.01F * kHalfStep));
    }
  }
}

TEST(Lean, IsNowhereAlongTheLineOfSight) {
  const Eigen::Vector3f view(0, 0, 1);
  EXPECT_EQ(LeanCode(view, Eigen::Vector3f::Zero()), kLeanNowhere);
  EXPECT_EQ(LeanCode(view, view), kLeanNowhere);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(LeanCode(view, {nan, 0, 0}), kLeanNowhere);
  EXPECT_FALSE(Leans(kLeanNowhere));
  EXPECT_FALSE(Leans(kLeanUnknown));
}

}  // namespace
}  // namespace livemvs
