#include <utility>

#include "livemvs/io/live_source.h"
#include "livemvs/io/pacer.h"

namespace livemvs {
namespace {

class Playback final : public LiveSource {
 public:
  Playback(std::unique_ptr<FrameSource> recording, const PlaybackOptions& options)
      : recording_(std::move(recording)), options_(options) {}

  FrameSource::Info info() const override { return recording_->info(); }
  FrameSource::Statistics statistics() const override { return recording_->statistics(); }
  void Cancel() override { pacer_.Cancel(); }

  Answer Next() override {
    Answer answer;
    if (pacer_.cancelled()) return answer;
    std::optional<SourceFrame> frame = recording_->Next();
    if (!frame || (options_.last_frame >= 0 && frame->index > options_.last_frame)) {
      answer.status = Status::kEnded;
      return answer;
    }
    const std::int64_t place = frame->index - options_.first_frame;
    if (place < 0 || place % options_.step != 0) return answer;
    if (options_.realtime) pacer_.WaitFor(frame->timestamp);
    answer.status = Status::kFrame;
    answer.frame = *std::move(frame);
    return answer;
  }

 private:
  std::unique_ptr<FrameSource> recording_;
  PlaybackOptions options_;
  Pacer pacer_;
};

}  // namespace

std::unique_ptr<LiveSource> PlayBack(std::unique_ptr<FrameSource> recording,
                                     const PlaybackOptions& options) {
  return std::make_unique<Playback>(std::move(recording), options);
}

}  // namespace livemvs
