#include "livemvs/scan/frame_gate.h"

#include <gtest/gtest.h>

#include <limits>

namespace livemvs {
namespace {

SourceFrame FrameAt(double time, std::uint8_t grey, int width = 8) {
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(width, 6);
  picture->grey(3, 5) = grey;
  SourceFrame frame;
  frame.timestamp = time;
  frame.picture = std::move(picture);
  return frame;
}

using Verdict = FrameGate::Verdict;

TEST(FrameGate, LetsGoodPicturesPassAndLeavesOthersOut) {
  FrameGate gate;
  EXPECT_EQ(gate.Judge(FrameAt(0.0, 1)), Verdict::kGood);
  EXPECT_EQ(gate.Judge(FrameAt(0.1, 2)), Verdict::kGood);
  EXPECT_EQ(gate.Judge(FrameAt(0.1, 3)), Verdict::kOutOfOrder) << "the same time";
  EXPECT_EQ(gate.Judge(FrameAt(0.05, 3)), Verdict::kOutOfOrder);
  EXPECT_EQ(gate.Judge(FrameAt(std::numeric_limits<double>::quiet_NaN(), 3)), Verdict::kOutOfOrder);
  EXPECT_EQ(gate.Judge(FrameAt(0.2, 2)), Verdict::kDuplicate);
  EXPECT_EQ(gate.Judge(FrameAt(0.2, 3, 10)), Verdict::kOtherSize);
  EXPECT_EQ(gate.Judge(FrameAt(0.2, 3)), Verdict::kGood) << "what was left out left no trace";
  EXPECT_EQ(gate.Judge(FrameAt(0.3, 2)), Verdict::kGood) << "the picture before the last";
}

}  // namespace
}  // namespace livemvs
