#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "livemvs/io/dataset.h"

namespace livemvs {

/// Reads a dataset on a thread of its own, a few frames ahead, so that decoding and reconstruction
/// overlap. No frame is ever dropped. While it lives, the dataset is the prefetcher's alone, but
/// for its views.
class Prefetcher {
 public:
  /// @param dataset  Must outlive the prefetcher.
  /// @param depth    Most frames that wait.
  explicit Prefetcher(Dataset* dataset, std::size_t depth = 4);
  ~Prefetcher();
  Prefetcher(const Prefetcher&) = delete;
  Prefetcher& operator=(const Prefetcher&) = delete;

  /// The next frame, or nothing at the end. Waits for it, unless `cancelled`, asked every now and
  /// then, says so: then nothing is returned.
  /// @throws what the dataset threw, after the frames before it.
  std::optional<PosedFrame> Next(const std::function<bool()>& cancelled = [] { return false; });

  /// The dataset's statistics as of the last frame that was read.
  Dataset::Statistics statistics();

 private:
  void Run();

  Dataset* dataset_;
  std::size_t depth_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<PosedFrame> queue_;
  Dataset::Statistics statistics_;
  std::exception_ptr failure_;
  bool finished_ = false;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace livemvs
