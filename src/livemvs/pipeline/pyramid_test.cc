#include "livemvs/pipeline/pyramid.h"

#include <gtest/gtest.h>

#include "livemvs/core/camera.h"

namespace livemvs {
namespace {

Image<std::uint8_t> Ramp(int width, int height) {
  Image<std::uint8_t> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = static_cast<std::uint8_t>(3 * x + y);
  }
  return image;
}

TEST(PyramidTest, LevelsShowWhatTheirCamerasSee) {
  const Image<std::uint8_t> image = Ramp(67, 41);  // odd: the last column and row are lost
  Pyramid pyramid;
  pyramid.Build(image, 2);
  ASSERT_EQ(pyramid.levels().size(), 2U);
  EXPECT_EQ(pyramid.levels()[0].data, image.view().data);
  const ImageView<std::uint8_t> half = pyramid.levels()[1];
  Camera camera;
  camera.width = 67, camera.height = 41;
  camera.fx = 50, camera.fy = 55, camera.cx = 31, camera.cy = 20;
  const Camera half_camera = AtLevel(camera, 1);
  EXPECT_EQ(half.width, half_camera.width);
  EXPECT_EQ(half.height, half_camera.height);
  // The ray through a pixel of the half meets the full picture where it has the same grey value:
  // the ramp is linear.
  for (const auto& [x, y] : {std::pair{0, 0}, {7, 3}, {32, 19}}) {
    const Eigen::Vector3d ray = *Projector(half_camera).Unproject({x, y});
    const Eigen::Vector2d p = *Projector(camera).Project(ray);
    EXPECT_NEAR(half(x, y), 3 * p.x() + p.y(), 0.5 + 1e-9);
  }
}

TEST(PyramidTest, TwoLevelsOfCamerasAreOneOfTheOther) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = 600, camera.fy = -590, camera.cx = 321.3, camera.cy = 238.9;
  const Camera direct = AtLevel(camera, 2), steps = AtLevel(AtLevel(camera, 1), 1);
  EXPECT_NEAR(direct.cx, steps.cx, 1e-12);
  EXPECT_NEAR(direct.cy, steps.cy, 1e-12);
  EXPECT_NEAR(direct.fy, steps.fy, 1e-12);
  EXPECT_EQ(direct.width, steps.width);
}

TEST(PyramidTest, LeavesOutLevelsTooSmallForAPatchAndFollowsAChangeOfSize) {
  Pyramid pyramid;
  const Image<std::uint8_t> small = Ramp(40, 33);
  pyramid.Build(small, 5);
  EXPECT_EQ(pyramid.levels().size(), 2U);
  const Image<std::uint8_t> large = Ramp(80, 200);
  pyramid.Build(large, 3);
  ASSERT_EQ(pyramid.levels().size(), 3U);
  EXPECT_EQ(pyramid.levels()[2].width, 20);
  EXPECT_EQ(pyramid.levels()[2].height, 50);
}

}  // namespace
}  // namespace livemvs
