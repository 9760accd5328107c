#include "livemvs/io/capture_queue.h"

#include <utility>

namespace livemvs {

CaptureQueue::CaptureQueue(LiveSource* source, const CaptureOptions& options)
    : source_(source), options_(options), thread_([this] { Run(); }) {}

CaptureQueue::~CaptureQueue() {
  Stop();
  thread_.join();
}

void CaptureQueue::Stop() {
  source_->Cancel();
  const std::lock_guard<std::mutex> lock(mutex_);
  stop_ = true;
  changed_.notify_all();
}

CaptureQueue::Item CaptureQueue::Next(std::chrono::milliseconds timeout) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(
      lock, timeout, [&] { return !waiting_.empty() || finished_ || !problem_.empty(); });
  Item item;
  if (!waiting_.empty()) {
    item.event = Event::kFrame;
    item.frame = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    return item;
  }
  if (finished_) {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    item.event = Event::kEnded;
    return item;
  }
  const std::chrono::duration<double> silent = Clock::now() - last_picture_;
  if (lost_ || (problem_.empty() && silent.count() < options_.lost_after)) {
    problem_.clear();
    return item;
  }
  lost_ = true;
  item.event = Event::kLost;
  item.problem = problem_.empty() ? "no picture comes" : std::exchange(problem_, {});
  return item;
}

std::int64_t CaptureQueue::dropped() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return dropped_;
}

FrameSource::Statistics CaptureQueue::statistics() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return statistics_;
}

double CaptureQueue::seconds_silent() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::chrono::duration<double>(Clock::now() - last_picture_).count();
}

bool CaptureQueue::Put(SourceFrame frame) {
  std::unique_lock<std::mutex> lock(mutex_);
  statistics_ = source_->statistics();
  last_picture_ = Clock::now();
  lost_ = false;
  problem_.clear();
  if (options_.drop_oldest) {
    while (waiting_.size() >= options_.depth) {
      waiting_.pop_front();
      ++dropped_;
    }
  }
  changed_.wait(lock, [&] { return waiting_.size() < options_.depth || stop_; });
  // A wait for room is no silence of the source.
  last_picture_ = Clock::now();
  if (stop_) return false;
  waiting_.push_back(std::move(frame));
  changed_.notify_all();
  return true;
}

void CaptureQueue::Run() {
  std::exception_ptr failure;
  try {
    while (true) {
      LiveSource::Answer answer = source_->Next();
      if (answer.status == LiveSource::Status::kEnded) break;
      if (answer.status == LiveSource::Status::kFrame) {
        if (!Put(std::move(answer.frame))) break;
        continue;
      }
      const std::lock_guard<std::mutex> lock(mutex_);
      if (stop_) break;
      if (answer.status == LiveSource::Status::kLost) {
        problem_ = std::move(answer.problem);
        changed_.notify_all();
      }
    }
  } catch (...) {
    failure = std::current_exception();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  statistics_ = source_->statistics();
  failure_ = failure;
  finished_ = true;
  changed_.notify_all();
}

}  // namespace livemvs
