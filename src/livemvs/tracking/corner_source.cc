#include "livemvs/tracking/corner_source.h"

#include "livemvs/tracking/frame_pose.h"

namespace livemvs {

struct CornerSource::Impl {
  explicit Impl(const Board& board) : poser(board, TrackerOptions()) {}
  FramePoser poser;
};

CornerSource::CornerSource(const Board& board) {
  board.Check();
  impl_ = std::make_unique<Impl>(board);
}

CornerSource::~CornerSource() = default;
CornerSource::CornerSource(CornerSource&&) noexcept = default;
CornerSource& CornerSource::operator=(CornerSource&&) noexcept = default;

CalibrationView CornerSource::Find(const Picture& picture) {
  const std::vector<FoundCorner> corners = impl_->poser.DetectCorners(picture.grey.view());
  return {impl_->poser.search().Observations(corners), MotionBlur(corners)};
}

}  // namespace livemvs
