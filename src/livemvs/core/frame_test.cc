#include "livemvs/core/frame.h"

#include <gtest/gtest.h>

namespace livemvs {
namespace {

Picture OnePixel(std::uint8_t y, std::uint8_t cb, std::uint8_t cr, bool full_range) {
  Picture picture;
  picture.grey = Image<std::uint8_t>(1, 1);
  picture.cb = Image<std::uint8_t>(1, 1);
  picture.cr = Image<std::uint8_t>(1, 1);
  picture.grey(0, 0) = y;
  picture.cb(0, 0) = cb;
  picture.cr(0, 0) = cr;
  picture.full_range = full_range;
  return picture;
}

TEST(PictureTest, ColorsOfBt601) {
  // The corners of the colour cube as ITU-R BT.601 codes them in studio range.
  EXPECT_EQ(OnePixel(235, 128, 128, false).ColorAt(0, 0), (Rgb{255, 255, 255}));
  EXPECT_EQ(OnePixel(16, 128, 128, false).ColorAt(0, 0), (Rgb{0, 0, 0}));
  const Rgb red = OnePixel(81, 90, 240, false).ColorAt(0, 0);
  EXPECT_NEAR(red[0], 255, 2);
  EXPECT_NEAR(red[1], 0, 2);
  EXPECT_NEAR(red[2], 0, 2);
  EXPECT_EQ(OnePixel(77, 128, 128, true).ColorAt(0, 0), (Rgb{77, 77, 77}));
}

TEST(PictureTest, GreyPictureHasNoChroma) {
  Picture picture;
  picture.grey = Image<std::uint8_t>(2, 1);
  picture.full_range = true;
  picture.grey(1, 0) = 200;
  EXPECT_EQ(picture.ColorAt(1, 0), (Rgb{200, 200, 200}));
}

}  // namespace
}  // namespace livemvs
