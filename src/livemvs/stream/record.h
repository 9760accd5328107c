#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace livemvs {

/// What a record of the stream says; the bytes of each are described in docs/data-formats.md.
/// Numbers are never reused. Readers pass over types that they do not know.
enum class RecordType : std::uint16_t {
  kSession = 1,        ///< A scan begins or is resumed: version, options.
  kCamera = 2,         ///< Intrinsics from here on.
  kScene = 3,          ///< Where surfaces are sought.
  kFrame = 4,          ///< One picture: its time, the camera's pose, the tracking state.
  kPoints = 5,         ///< New points, with ids that follow each other.
  kPointsRefined = 6,  ///< Points that replace those of the same ids.
  kPointsRemoved = 7,  ///< Ids of points that are no more.
  kStatistics = 8,     ///< Counts and rates, as JSON.
  kMessage = 9,        ///< A line for people.
  kEnd = 10,           ///< The scan is over; only a kSession may follow.
};

/// One record. `payload` points into the bytes that were parsed.
struct Record {
  RecordType type = RecordType::kMessage;
  std::uint32_t sequence = 0;
  std::span<const std::uint8_t> payload;
};

/// First bytes of every record, and so of every journal.
inline constexpr char kRecordMagic[] = "LMVR";
inline constexpr std::size_t kRecordHeaderBytes = 20;
/// Longer payloads are refused, so that a damaged length cannot ask for memory. [bytes]
inline constexpr std::size_t kMaxPayloadBytes = std::size_t{16} << 20;

/// Appends a record to `out`: header, payload, and zeros up to a multiple of 4 bytes.
/// @throws std::invalid_argument where the payload is longer than kMaxPayloadBytes.
void AppendRecord(RecordType type,
                  std::uint32_t sequence,
                  std::span<const std::uint8_t> payload,
                  std::vector<std::uint8_t>* out);

enum class ParseStatus {
  kRecord,      ///< There it is.
  kIncomplete,  ///< The bytes end within it; more may come.
  kCorrupt,     ///< They are no record, or not the expected one.
};

struct ParseResult {
  ParseStatus status = ParseStatus::kIncomplete;
  Record record;               ///< Of kRecord.
  std::size_t bytes_used = 0;  ///< Of kRecord: the next one begins here.
};

/// Parses the record at the front of `bytes`. Never reads beyond them, whatever they hold.
ParseResult ParseRecord(std::span<const std::uint8_t> bytes);

}  // namespace livemvs
