#include "livemvs/io/prefetcher.h"

#include <chrono>
#include <utility>

namespace livemvs {

Prefetcher::Prefetcher(Dataset* dataset, std::size_t depth)
    : dataset_(dataset), depth_(depth), thread_([this] { Run(); }) {}

Prefetcher::~Prefetcher() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::optional<PosedFrame> Prefetcher::Next(const std::function<bool()>& cancelled) {
  std::unique_lock<std::mutex> lock(mutex_);
  constexpr auto kPatience = std::chrono::milliseconds(100);
  while (true) {
    if (cancelled()) return std::nullopt;
    if (changed_.wait_for(lock, kPatience, [&] { return !queue_.empty() || finished_; })) break;
  }
  if (queue_.empty()) {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::nullopt;
  }
  PosedFrame frame = std::move(queue_.front());
  queue_.pop_front();
  changed_.notify_all();
  return frame;
}

Dataset::Statistics Prefetcher::statistics() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return statistics_;
}

void Prefetcher::Run() {
  std::exception_ptr failure;
  try {
    while (true) {
      std::optional<PosedFrame> frame = dataset_->Next();
      std::unique_lock<std::mutex> lock(mutex_);
      statistics_ = dataset_->statistics();
      if (!frame) break;
      changed_.wait(lock, [&] { return queue_.size() < depth_ || stop_; });
      if (stop_) break;
      queue_.push_back(*std::move(frame));
      changed_.notify_all();
    }
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  failure_ = failure;
  finished_ = true;
  changed_.notify_all();
}

}  // namespace livemvs
