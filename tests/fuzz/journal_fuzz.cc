// Hostile bytes as a scan's journal: read whole, as it is when a scan is resumed, and growing, as
// 'livemvs view' follows it. The first byte says where it grows.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>

#include "file_input.h"
#include "livemvs/core/error.h"
#include "livemvs/stream/journal.h"
#include "livemvs/stream/replay.h"

namespace livemvs {
namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

struct Seen {
  std::size_t records = 0;
  std::int64_t valid_bytes = 0;
};

void ReadOn(JournalReader* journal, std::size_t size, Seen* seen) {
  while (const std::optional<Record> record = journal->Next()) {
    ++seen->records;
    Require(record->payload.size() <= size);
  }
  Require(journal->valid_bytes() >= seen->valid_bytes);
  Require(journal->valid_bytes() <= static_cast<std::int64_t>(size));
  seen->valid_bytes = journal->valid_bytes();
}

// A journal that grows holds what it holds when it has grown.
void Follow(std::span<const std::uint8_t> bytes, std::size_t split) {
  Seen whole, grown;
  try {
    const FileInput file(bytes);
    JournalReader journal(file.path());
    ReadOn(&journal, bytes.size(), &whole);
  } catch (const Error&) {
    return;
  }
  try {
    FileInput file(bytes.first(split));
    JournalReader journal(file.path());
    ReadOn(&journal, split, &grown);
    if (journal.tail() == JournalReader::Tail::kCorrupt) return;
    file.Append(bytes.subspan(split));
    ReadOn(&journal, bytes.size(), &grown);
  } catch (const Error&) {
    return;  // nothing was there that a journal begins with
  }
  Require(grown.records == whole.records && grown.valid_bytes == whole.valid_bytes);
}

void Resume(std::span<const std::uint8_t> bytes) {
  try {
    const FileInput file(bytes);
    const JournalContents contents = ReadJournal(file.path());
    Require(contents.valid_bytes <= static_cast<std::int64_t>(bytes.size()));
    Require(!contents.replay.sessions().empty());
  } catch (const Error&) {
    return;
  }
}

}  // namespace
}  // namespace livemvs

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  livemvs::Follow(bytes, bytes.size() * data[0] / 255);
  livemvs::Resume(bytes);
  return 0;
}
