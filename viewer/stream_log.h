#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "livemvs/stream/record.h"
#include "livemvs/stream/record_sink.h"

namespace livemvs::viewer {

using SharedBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

/// Records that only viewers get: they are not kept, and a journal has none. Their payloads are
/// described in docs/viewer.md.
inline constexpr auto kRecordHello = static_cast<RecordType>(256);    ///< First to each client.
inline constexpr auto kRecordPreview = static_cast<RecordType>(257);  ///< The camera's picture.
inline constexpr auto kRecordLive = static_cast<RecordType>(258);     ///< Counts of this moment.
/// The sequence number of all of these.
inline constexpr std::uint32_t kUnnumbered = 0xFFFFFFFFU;

/// The stream as viewers get it: all records so far, numbered, and the latest picture and counts,
/// each of which takes the place of the one before. Writers never wait for readers, and readers
/// keep a number instead of a queue: a slow one costs no memory. Thread-safe.
class StreamLog final : public RecordSink {
 public:
  /// What a reader has had.
  struct Cursor {
    std::uint32_t next = 0;     ///< Number of the next record.
    std::uint64_t preview = 0;  ///< Versions of what is replaced.
    std::uint64_t live = 0;
  };

  StreamLog();

  /// Adds a record under the next number.
  void Append(RecordType type, std::span<const std::uint8_t> payload);
  void Write(RecordType type, std::span<const std::uint8_t> payload) override {
    Append(type, payload);
  }
  void SetPreview(std::span<const std::uint8_t> payload);
  void SetLive(const std::string& json);

  /// The next things for a reader, and moves its cursor on: records up to about `most_bytes`; or,
  /// where it has them all, what was replaced since. Empty: nothing new.
  std::vector<SharedBytes> Take(Cursor* cursor, std::size_t most_bytes) const;

  /// A name of this stream: a reader that had a part of it goes on, of another begins anew.
  const std::string& session() const { return session_; }
  std::uint32_t size() const;
  std::size_t bytes() const;

  /// Called after each change, from the thread that made it; must be quick, and not use the log.
  /// An empty one ends it: none is under way then.
  void SetListener(std::function<void()> listener);

 private:
  const std::string session_;
  mutable std::mutex mutex_;
  std::vector<SharedBytes> records_;
  std::size_t bytes_ = 0;
  SharedBytes preview_, live_;
  std::uint64_t preview_version_ = 0, live_version_ = 0;
  std::function<void()> listener_;
};

/// A record that is not part of the numbered stream.
SharedBytes MakeUnnumbered(RecordType type, std::span<const std::uint8_t> payload);

}  // namespace livemvs::viewer
