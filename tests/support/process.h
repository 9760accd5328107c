#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace livemvs::testing_support {

/// A program that runs beside the test, with what it writes to standard error.
class Process {
 public:
  using Clock = std::chrono::steady_clock;
  struct Line {
    Clock::time_point time;
    std::string text;
  };

  /// @param prepare  Run in the new process before the program: limits and the like. May be empty.
  explicit Process(std::vector<std::string> command, const std::function<void()>& prepare = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void Kill(int signal) const;
  /// Its exit code; 128 + the signal that ended it.
  int Wait();
  /// What it wrote so far.
  std::vector<Line> lines();
  std::string text();
  /// Waits until it has written this, for up to a minute.
  bool WaitFor(const std::string& text);

 private:
  void Read(int fd);

  pid_t pid_ = -1;
  int status_ = -1;
  bool waited_ = false;
  std::mutex mutex_;
  std::vector<Line> lines_;
  std::thread reader_;
};

/// Notices when the machine gives this process no time: a test on the clock can allow for it.
class PauseWatch {
 public:
  PauseWatch();
  ~PauseWatch();
  PauseWatch(const PauseWatch&) = delete;
  PauseWatch& operator=(const PauseWatch&) = delete;

  /// Of all pauses since it was made [s]; those too short to matter are not counted.
  double Total() const;

 private:
  std::atomic<bool> stop_ = false;
  std::atomic<std::int64_t> milliseconds_ = 0;
  std::thread thread_;
};

}  // namespace livemvs::testing_support
