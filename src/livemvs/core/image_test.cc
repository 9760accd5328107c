#include "livemvs/core/image.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace livemvs {
namespace {

TEST(ImageTest, RowsAreAlignedZeroedAndPadded) {
  const Image<std::uint8_t> image(65, 3);
  EXPECT_EQ(image.stride(), 128);
  volatile int sum = 0;
  for (int y = 0; y < 3; ++y) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.Row(y)) % 64, 0U);
    for (int x = 0; x < 65; ++x) EXPECT_EQ(image(x, y), 0);
    // 64 bytes past the end of a row may be read: the address sanitizer would object.
    for (int x = 65; x < 65 + 64; ++x) sum = sum + image.Row(y)[x];
  }
}

TEST(ImageTest, MovesLeaveNothingBehind) {
  Image<float> a(4, 2);
  a(3, 1) = 7;
  const Image<float> b = std::move(a);
  EXPECT_EQ(b(3, 1), 7);
  EXPECT_TRUE(a.empty());  // NOLINT(bugprone-use-after-move): documented
  EXPECT_TRUE(Image<float>().empty());
  EXPECT_EQ(b.view()(3, 1), 7);
  EXPECT_EQ(b.view().width, 4);
}

}  // namespace
}  // namespace livemvs
