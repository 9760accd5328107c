#include "livemvs/synth/printed_sheet.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace livemvs::synth {
namespace {

// Upper left pixel black, the other three white, on 20 x 20 mm.
PrintedSheet Corner() {
  Image<std::uint8_t> picture(2, 2);
  picture(1, 0) = picture(0, 1) = picture(1, 1) = 255;
  return PrintedSheet(picture, 0.02);
}

TEST(PrintedSheet, LiesAboutTheOriginWithYUp) {
  const PrintedSheet sheet = Corner();
  EXPECT_DOUBLE_EQ(sheet.height(), 0.02);
  EXPECT_FLOAT_EQ(sheet.PaperAt(-0.005f, 0.005f, 1e-4f), 0);
  EXPECT_FLOAT_EQ(sheet.PaperAt(0.005f, 0.005f, 1e-4f), 1);
  EXPECT_FLOAT_EQ(sheet.PaperAt(-0.005f, -0.005f, 1e-4f), 1);
}

TEST(PrintedSheet, MeansAreExact) {
  const PrintedSheet sheet = Corner();
  EXPECT_NEAR(sheet.PaperAt(0, 0, 0.01f), 0.75f, 1e-6f);
  EXPECT_NEAR(sheet.PaperAt(0, 0.005f, 0.004f), 0.5f, 1e-6f);
  EXPECT_NEAR(sheet.PaperAt(0.001f, 0.005f, 0.004f), 0.75f, 1e-6f);
}

TEST(PrintedSheet, RefusesNothing) {
  EXPECT_THROW(PrintedSheet(Image<std::uint8_t>(), 0.1), std::invalid_argument);
  EXPECT_THROW(PrintedSheet(Image<std::uint8_t>(2, 2), 0), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs::synth
