#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "livemvs/io/live_source.h"

namespace livemvs {

struct CaptureOptions {
  std::size_t depth = 4;  ///< Most pictures that wait.
  /// Late pictures make room by dropping the oldest that waits; otherwise the source waits.
  bool drop_oldest = false;
  /// Without a picture for so long, the camera counts as lost. [s]
  double lost_after = 0.8;
};

/// Reads a live source on a thread of its own.
class CaptureQueue {
 public:
  enum class Event {
    kFrame,
    kNothing,  ///< Nothing came in time.
    kLost,     ///< Said once, each time that pictures stay away.
    kEnded,
  };
  struct Item {
    Event event = Event::kNothing;
    SourceFrame frame;    ///< Of kFrame.
    std::string problem;  ///< Of kLost, for people.
  };

  /// @param source  Must outlive the queue, and is its alone meanwhile.
  CaptureQueue(LiveSource* source, const CaptureOptions& options);
  ~CaptureQueue();
  CaptureQueue(const CaptureQueue&) = delete;
  CaptureQueue& operator=(const CaptureQueue&) = delete;

  /// The next picture, or what there is to say instead. After kEnded always kEnded.
  /// @throws what the source threw, after the pictures before it.
  Item Next(std::chrono::milliseconds timeout);

  /// Stops the source; pictures that wait can still be had.
  void Stop();

  std::int64_t dropped();
  /// The source's, as of its last picture.
  FrameSource::Statistics statistics();
  /// [s] since the last picture came, or since the start.
  double seconds_silent();

 private:
  using Clock = std::chrono::steady_clock;
  void Run();
  bool Put(SourceFrame frame);

  LiveSource* source_;
  CaptureOptions options_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SourceFrame> waiting_;
  std::int64_t dropped_ = 0;
  FrameSource::Statistics statistics_;
  Clock::time_point last_picture_ = Clock::now();
  std::string problem_;  ///< Not yet handed out.
  bool lost_ = false;    ///< kLost was said, and no picture came since.
  bool finished_ = false;
  bool stop_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace livemvs
