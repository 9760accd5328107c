#include "live_calibrate.h"

#include <chrono>
#include <memory>

#include "interrupt.h"
#include "livemvs/core/log.h"
#include "progress.h"

namespace livemvs::app {
namespace {

using Clock = std::chrono::steady_clock;

/// Says what to film next, where that is new: not more often than one can read.
class Prompter {
 public:
  void Say(int views, const std::string& prompt) {
    if (prompt.empty() || prompt == said_ || Clock::now() - last_ < kPause) return;
    said_ = prompt;
    last_ = Clock::now();
    LogInfo(std::to_string(views) + " views; " + prompt);
  }

 private:
  static constexpr std::chrono::milliseconds kPause{1500};
  std::string said_;
  Clock::time_point last_{};
};

}  // namespace

LiveCalibrationResult CalibrateFromLive(const LiveArguments& args,
                                        const Board& board,
                                        const CalibratorOptions& options,
                                        const std::string& progress_mode) {
  const ProgressMode mode = ParseProgressMode(progress_mode);
  const std::unique_ptr<LiveSource> source = OpenLive(args);
  LogInfo(source->info().description + "; Ctrl-C ends the calibration with the views so far");
  Progress progress(mode == ProgressMode::kJson ? mode : ProgressMode::kNone);
  Prompter prompter;
  LiveCalibrationWatch watch;
  watch.stop = Interrupted;
  watch.news = [](const std::string& text, bool warning) {
    warning ? LogWarning(text) : LogInfo(text);
  };
  watch.progress = [&](std::int64_t frames, int views, const std::string& prompt) {
    progress.Show({"calibrate", frames, 0, 0, 0, std::to_string(views) + " views; " + prompt});
    prompter.Say(views, prompt);
  };
  LiveCalibrationResult result =
      CalibrateLive(source.get(), board, {options, args.patience}, watch);
  progress.Finish();
  if (result.source_lost) LogWarning("the camera did not come back");
  return result;
}

}  // namespace livemvs::app
