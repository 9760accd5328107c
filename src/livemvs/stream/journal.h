#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "livemvs/stream/record.h"

namespace livemvs {

/// Appends records to a journal file. What was flushed outlives the process, what was synced the
/// machine's power too. Not thread-safe.
///
/// A write that fails - disk full, device gone - throws Error (kOutOfResource) with the path and
/// the system's reason. Before that the file is cut back to its last whole record, which stays
/// readable; the writer refuses everything after that.
class JournalWriter {
 public:
  /// Begins a new journal. @throws Error (kOutOfResource) where the file is there or cannot be
  /// made.
  explicit JournalWriter(const std::filesystem::path& path);
  /// Goes on with a journal from `valid_bytes`, cutting off what follows, and numbers records from
  /// `next_sequence`: both as JournalReader says them.
  JournalWriter(const std::filesystem::path& path,
                std::int64_t valid_bytes,
                std::uint32_t next_sequence);
  ~JournalWriter();
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  /// Adds a record; it is in memory until Flush(), or until much has gathered.
  void Append(RecordType type, std::span<const std::uint8_t> payload);
  /// Hands everything to the system.
  void Flush();
  /// Flush(), and waits until it is on the disk.
  void Sync();

  /// Another handle of the file, for syncing it from another thread; the caller closes it.
  /// @throws Error (kOutOfResource) where there is none to be had.
  int DuplicateHandle() const;

  std::uint32_t next_sequence() const { return next_sequence_; }
  /// Of whole records, those in memory included.
  std::int64_t size() const { return flushed_ + static_cast<std::int64_t>(buffer_.size()); }
  bool failed() const { return failed_; }

 private:
  void Open(int flags);
  [[noreturn]] void Fail(const char* what, int error);
  void CheckUsable() const;

  std::filesystem::path path_;
  int fd_ = -1;
  std::int64_t flushed_ = 0;
  std::uint32_t next_sequence_ = 0;
  std::vector<std::uint8_t> buffer_;
  bool failed_ = false;
};

/// Reads a journal, which may be growing, or have been cut anywhere. Not thread-safe.
class JournalReader {
 public:
  /// @throws Error (kBadInput) where the file is missing, unreadable, or begins like something
  /// else.
  explicit JournalReader(const std::filesystem::path& path);
  ~JournalReader();
  JournalReader(const JournalReader&) = delete;
  JournalReader& operator=(const JournalReader&) = delete;

  /// The next record, or nothing where no whole one follows: at the end, before a torn tail, or for
  /// good after damage. Ask again later where the journal is being written. The payload is valid
  /// until the next call.
  std::optional<Record> Next();

  /// Why Next() gave nothing.
  enum class Tail {
    kClean,   ///< The file ends with a whole record.
    kTorn,    ///< It ends within one.
    kCorrupt  ///< What follows is no record, or not the next one.
  };
  Tail tail() const { return tail_; }

  /// The end of the last record that was read. [bytes from the start]
  std::int64_t valid_bytes() const { return valid_bytes_; }
  /// The number that the next record must have.
  std::uint32_t next_sequence() const { return next_sequence_; }

 private:
  bool Fill();

  std::filesystem::path path_;
  int fd_ = -1;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  ///< Of what is unread in the buffer.
  std::int64_t valid_bytes_ = 0;
  std::uint32_t next_sequence_ = 0;
  Tail tail_ = Tail::kClean;
};

}  // namespace livemvs
