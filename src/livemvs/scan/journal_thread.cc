#include "livemvs/scan/journal_thread.h"

#include <chrono>
#include <utility>

namespace livemvs {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kMostWaiting = 4096;
constexpr milliseconds kFlushEvery{200};
constexpr milliseconds kSyncEvery{800};

}  // namespace

JournalThread::JournalThread(std::unique_ptr<JournalWriter> journal)
    : journal_(std::move(journal)), queue_(kMostWaiting), thread_([this] { Run(); }) {}

JournalThread::~JournalThread() {
  queue_.Close();
  if (thread_.joinable()) thread_.join();
}

void JournalThread::Write(RecordType type, std::span<const std::uint8_t> payload) {
  queue_.Push({type, {payload.begin(), payload.end()}});
}

void JournalThread::Finish() {
  queue_.Close();
  if (thread_.joinable()) thread_.join();
  if (failed_) std::rethrow_exception(failure_);
}

void JournalThread::Run() {
  try {
    Loop();
    journal_->Sync();
  } catch (...) {
    failure_ = std::current_exception();
    failed_ = true;
  }
  // Nobody may wait for a disk that is full.
  while (!queue_.finished()) queue_.Pop(kFlushEvery);
}

void JournalThread::Loop() {
  Clock::time_point flushed = Clock::now();
  Clock::time_point synced = flushed;
  while (!queue_.finished()) {
    if (const std::optional<Pending> record = queue_.Pop(kFlushEvery)) {
      journal_->Append(record->type, record->payload);
    }
    const Clock::time_point now = Clock::now();
    if (now - synced >= kSyncEvery) {
      journal_->Sync();
      flushed = synced = Clock::now();
    } else if (now - flushed >= kFlushEvery) {
      journal_->Flush();
      flushed = Clock::now();
    }
  }
}

}  // namespace livemvs
