#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

namespace livemvs {

/// Holds frames of a recording back until they would have been filmed. Not thread-safe, but for
/// Cancel().
class Pacer {
 public:
  /// Waits until `timestamp` [s], the first one being now.
  void WaitFor(double timestamp) {
    const Clock::time_point now = Clock::now();
    if (!start_) {
      start_ = now - std::chrono::duration_cast<Clock::duration>(
                         std::chrono::duration<double>(timestamp));
    }
    const Clock::time_point due = *start_ + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(timestamp));
    constexpr auto kSlice = std::chrono::milliseconds(50);
    while (!cancelled_ && Clock::now() < due) {
      std::this_thread::sleep_until(std::min<Clock::time_point>(due, Clock::now() + kSlice));
    }
  }

  void Cancel() { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }

 private:
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> start_;
  std::atomic<bool> cancelled_ = false;
};

}  // namespace livemvs
