#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace livemvs::app {

/// How progress is shown: a line that renews itself, one JSON object a line, or not at all.
enum class ProgressMode { kAuto, kLine, kJson, kNone };

/// @throws std::invalid_argument unless text is "auto", "line", "json" or "none".
ProgressMode ParseProgressMode(const std::string& text);

struct ProgressState {
  std::string stage;
  std::int64_t done = 0;   ///< Frames.
  std::int64_t total = 0;  ///< Frames, or 0 where unknown.
  std::int64_t seeds = 0;
  std::int64_t points = 0;
  std::string note;      ///< What else there is to say; may be empty.
  bool percent = false;  ///< Only `stage` and `done`, in per cent, mean something.
};

/// Shows progress on standard error, at most a few times a second.
class Progress {
 public:
  /// kAuto: a line on a terminal, else nothing.
  explicit Progress(ProgressMode mode);
  ~Progress();

  void Show(const ProgressState& state);
  /// Shows how much of a stage is done, 0 to 1.
  void ShowShare(const std::string& stage, double share);
  /// Shows the last state, whenever it was, and ends the line.
  void Finish();

 private:
  using Clock = std::chrono::steady_clock;
  void Print(const ProgressState& state);
  void PrintPercent(const ProgressState& state);

  ProgressMode mode_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_{};
  ProgressState state_;
  bool pending_ = false;
  bool open_line_ = false;
};

}  // namespace livemvs::app
