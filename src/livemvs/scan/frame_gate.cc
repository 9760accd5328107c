#include "livemvs/scan/frame_gate.h"

#include <cmath>
#include <cstring>

namespace livemvs {
namespace {

bool SamePixels(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  for (int y = 0; y < a.height(); ++y) {
    if (std::memcmp(a.Row(y), b.Row(y), static_cast<std::size_t>(a.width())) != 0) return false;
  }
  return true;
}

}  // namespace

FrameGate::Verdict FrameGate::Judge(const SourceFrame& frame) {
  if (!std::isfinite(frame.timestamp) || (last_time_ && !(frame.timestamp > *last_time_))) {
    return Verdict::kOutOfOrder;
  }
  if (last_picture_ != nullptr) {
    if (frame.picture->width() != last_picture_->width() ||
        frame.picture->height() != last_picture_->height()) {
      return Verdict::kOtherSize;
    }
    if (SamePixels(frame.picture->grey, last_picture_->grey)) return Verdict::kDuplicate;
  }
  last_time_ = frame.timestamp;
  last_picture_ = frame.picture;
  return Verdict::kGood;
}

}  // namespace livemvs
