#include "livemvs/scan/journal_thread.h"

#include <unistd.h>

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
    : journal_(std::move(journal)),
      queue_(kMostWaiting),
      sync_handle_(journal_->DuplicateHandle()),
      syncer_([this] { SyncNowAndThen(); }),
      thread_([this] { Run(); }) {}

JournalThread::~JournalThread() {
  queue_.Close();
  if (thread_.joinable()) thread_.join();
  StopSyncing();
}

void JournalThread::Write(RecordType type, std::span<const std::uint8_t> payload) {
  queue_.Push({type, {payload.begin(), payload.end()}});
}

void JournalThread::Finish() {
  queue_.Close();
  if (thread_.joinable()) thread_.join();
  StopSyncing();
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
  while (!queue_.finished()) {
    if (const std::optional<Pending> record = queue_.Pop(kFlushEvery / 4)) {
      journal_->Append(record->type, record->payload);
    }
    if (Clock::now() - flushed < kFlushEvery) continue;
    journal_->Flush();
    flushed = Clock::now();
  }
}

void JournalThread::SyncNowAndThen() {
  std::unique_lock<std::mutex> lock(sync_mutex_);
  while (!sync_changed_.wait_for(lock, kSyncEvery, [this] { return stop_syncing_; })) {
    lock.unlock();
    ::fdatasync(sync_handle_);  // what it cannot do, the last Sync() tells
    lock.lock();
  }
}

void JournalThread::StopSyncing() {
  {
    const std::lock_guard<std::mutex> lock(sync_mutex_);
    stop_syncing_ = true;
  }
  sync_changed_.notify_all();
  if (syncer_.joinable()) syncer_.join();
  if (sync_handle_ >= 0) ::close(sync_handle_);
  sync_handle_ = -1;
}

}  // namespace livemvs
