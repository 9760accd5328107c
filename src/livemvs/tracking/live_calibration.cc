#include "livemvs/tracking/live_calibration.h"

#include <chrono>
#include <optional>
#include <stdexcept>
#include <utility>

#include "livemvs/io/capture_queue.h"
#include "livemvs/tracking/calibration_guide.h"
#include "livemvs/tracking/corner_source.h"

namespace livemvs {
namespace {

constexpr std::chrono::milliseconds kSlice{100};
constexpr int kViewsBetween = 3;  // new ones before another attempt

class Session {
 public:
  Session(const Board& board,
          const LiveCalibrationOptions& options,
          const LiveCalibrationWatch& watch)
      : options_(options), watch_(watch), corners_(board) {}

  // False where nothing is missing any more.
  bool Take(const SourceFrame& frame) {
    const Picture& picture = *frame.picture;
    if (!calibrator_) Begin(picture.width(), picture.height());
    ++result_.frames;
    if (picture.width() != width_ || picture.height() != height_) return true;
    const CalibrationView view = corners_.Find(picture);
    result_.with_board += view.observations.empty() ? 0 : 1;
    if (calibrator_->Add(view)) {
      guide_->Add(view);
      ++added_;
    }
    const bool done = Try();
    Tell(done ? std::string() : guide_->Missing().empty() ? problem_ : guide_->Next(view));
    return !done;
  }

  LiveCalibrationResult Finish() {
    if (calibrator_ && !solved_) result_.calibration = calibrator_->Solve();
    if (!calibrator_) result_.calibration.problem = "no picture came";
    return result_;
  }

  void News(const std::string& text, bool warning) const {
    if (watch_.news) watch_.news(text, warning);
  }
  void SourceLost() { result_.source_lost = true; }

 private:
  void Begin(int width, int height) {
    width_ = width;
    height_ = height;
    calibrator_.emplace(width, height, options_.calibrator);
    guide_.emplace(width, height, options_.calibrator);
  }

  // Calibrates once no view is missing; anew after some more where that was not good.
  bool Try() {
    if (!guide_->Missing().empty() || (!problem_.empty() && added_ < kViewsBetween)) return false;
    added_ = 0;
    result_.calibration = calibrator_->Solve();
    problem_ = result_.calibration.problem;
    solved_ = problem_.empty();
    return solved_;
  }

  void Tell(const std::string& prompt) const {
    if (watch_.progress) watch_.progress(result_.frames, calibrator_->views(), prompt);
  }

  const LiveCalibrationOptions& options_;
  const LiveCalibrationWatch& watch_;
  CornerSource corners_;
  int width_ = 0, height_ = 0;
  std::optional<Calibrator> calibrator_;
  std::optional<CalibrationGuide> guide_;
  int added_ = 0;  // views since the last attempt
  std::string problem_;
  bool solved_ = false;
  LiveCalibrationResult result_;
};

}  // namespace

void LiveCalibrationOptions::Check() const {
  calibrator.Check();
  if (!(patience > 0)) throw std::invalid_argument("calibration: patience must be positive");
}

LiveCalibrationResult CalibrateLive(LiveSource* source,
                                    const Board& board,
                                    const LiveCalibrationOptions& options,
                                    const LiveCalibrationWatch& watch) {
  options.Check();
  Session session(board, options, watch);
  CaptureQueue capture(source, {.depth = 2, .drop_oldest = true});
  bool lost = false;
  while (!watch.stop || !watch.stop()) {
    const CaptureQueue::Item item = capture.Next(kSlice);
    if (item.event == CaptureQueue::Event::kEnded) break;
    if (item.event == CaptureQueue::Event::kFrame) {
      if (std::exchange(lost, false)) session.News("pictures come again", false);
      if (!session.Take(item.frame)) break;
    } else if (item.event == CaptureQueue::Event::kLost) {
      lost = true;
      session.News("camera lost: " + item.problem, true);
    } else if (lost && capture.seconds_silent() >= options.patience) {
      session.SourceLost();
      break;
    }
  }
  return session.Finish();
}

}  // namespace livemvs
