#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "live_view.h"
#include "livemvs/core/scene_range.h"
#include "livemvs/pipeline/reconstructor.h"

namespace livemvs::app {

/// What 'run' shows while it works, if anything: the viewer, at the recording's own speed or the
/// machine's.
class RunView {
 public:
  struct Settings {
    PageOptions view;
    double speed = 0;  ///< Of the recording; 0: the machine's.
    std::string title;
  };
  RunView(const Settings& settings,
          const Options& options,
          const SceneRange& range,
          const std::string& source);

  /// Shows a frame and what converged in it; waits while the page says pause.
  /// @return False where the page said finish.
  bool Show(const PosedFrame& frame,
            std::span<const Point> converged,
            std::int64_t frame_count,
            const Reconstructor& reconstructor);

  /// Tells how the run ended; the viewer stays open until a signal comes.
  void Close(std::int64_t frames, std::int64_t points, const std::exception_ptr& failure);

 private:
  using Clock = std::chrono::steady_clock;
  void Pace(double timestamp);
  void StandWhilePaused();

  double speed_;
  Clock::time_point start_ = Clock::now();
  std::optional<double> first_time_;
  std::unique_ptr<LiveView> view_;
};

}  // namespace livemvs::app
