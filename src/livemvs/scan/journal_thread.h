#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "livemvs/io/bounded_queue.h"
#include "livemvs/stream/journal.h"
#include "livemvs/stream/record_sink.h"

namespace livemvs {

/// Writes a journal on a thread of its own: what was given to it is with the system within 0.2 s,
/// and on the disk within about a second, as fast as that is. Another thread waits for the disk, so
/// that a slow one does not keep records from the system. After a write that failed, records are
/// dropped.
class JournalThread final : public RecordSink {
 public:
  explicit JournalThread(std::unique_ptr<JournalWriter> journal);
  ~JournalThread() override;

  /// Waits where the disk is far behind.
  void Write(RecordType type, std::span<const std::uint8_t> payload) override;

  /// Whether a write failed: nothing is recorded any more.
  bool failed() const { return failed_; }
  /// That failure, or null.
  std::exception_ptr failure() const { return failed_ ? failure_ : nullptr; }

  /// Writes what is left and waits until it is on the disk. Nothing may be written afterwards.
  /// @throws Error where this write failed, or one before.
  void Finish();

 private:
  struct Pending {
    RecordType type;
    std::vector<std::uint8_t> payload;
  };
  void Run();
  void Loop();
  void SyncNowAndThen();
  void StopSyncing();

  std::unique_ptr<JournalWriter> journal_;
  BoundedQueue<Pending> queue_;
  std::atomic<bool> failed_ = false;
  std::exception_ptr failure_;  ///< Set before failed_.
  int sync_handle_ = -1;
  bool stop_syncing_ = false;  ///< Guarded by the mutex.
  std::mutex sync_mutex_;
  std::condition_variable sync_changed_;
  std::thread syncer_;
  std::thread thread_;
};

}  // namespace livemvs
