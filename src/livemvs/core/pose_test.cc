#include "livemvs/core/pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace livemvs {
namespace {

TEST(Rigid3dTest, InverseAndCompositionCancel) {
  const Rigid3d b_from_a = {
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix(),
      {0.5, -2, 3}};
  const Rigid3d c_from_b = {
      Eigen::AngleAxisd(-1.1, Eigen::Vector3d(0, 1, 1).normalized()).toRotationMatrix(),
      {-1, 0.25, 2}};
  const Eigen::Vector3d p(0.3, 0.4, 5);
  EXPECT_TRUE((b_from_a.Inverse() * (b_from_a * p)).isApprox(p, 1e-14));
  EXPECT_TRUE(((c_from_b * b_from_a) * p).isApprox(c_from_b * (b_from_a * p), 1e-14));
  EXPECT_TRUE((b_from_a * b_from_a.Center()).isZero(1e-14));
  EXPECT_TRUE(b_from_a.Inverse().translation.isApprox(b_from_a.Center(), 1e-14));
}

}  // namespace
}  // namespace livemvs
