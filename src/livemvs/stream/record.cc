#include "livemvs/stream/record.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "livemvs/stream/bytes.h"

namespace livemvs {
namespace {

// The header's fields, by their offset [bytes].
constexpr std::size_t kTypeAt = 4;
constexpr std::size_t kChecksumAt = 16;

std::size_t Padding(std::size_t length) { return (4 - length % 4) % 4; }

// CRC-32 of all but the magic and the checksum itself.
std::uint32_t ChecksumOf(ByteSpan header, ByteSpan payload) {
  uLong crc = crc32(0, header.data() + kTypeAt, static_cast<uInt>(kChecksumAt - kTypeAt));
  if (!payload.empty()) crc = crc32(crc, payload.data(), static_cast<uInt>(payload.size()));
  return static_cast<std::uint32_t>(crc);
}

}  // namespace

void AppendRecord(RecordType type, std::uint32_t sequence, ByteSpan payload, Bytes* out) {
  if (payload.size() > kMaxPayloadBytes) {
    throw std::invalid_argument("a record's payload of " + std::to_string(payload.size()) +
                                " bytes is too long");
  }
  Bytes header(kRecordMagic, kRecordMagic + 4);
  ByteWriter writer(&header);
  writer.Put(static_cast<std::uint16_t>(type));
  writer.Put(std::uint16_t{0});
  writer.Put(static_cast<std::uint32_t>(payload.size()));
  writer.Put(sequence);
  writer.Put(ChecksumOf(header, payload));
  out->insert(out->end(), header.begin(), header.end());
  out->insert(out->end(), payload.begin(), payload.end());
  out->insert(out->end(), Padding(payload.size()), 0);
}

ParseResult ParseRecord(ByteSpan bytes) {
  ParseResult result;
  const std::size_t magic = std::min<std::size_t>(bytes.size(), 4);
  if (magic > 0 && std::memcmp(bytes.data(), kRecordMagic, magic) != 0) {
    result.status = ParseStatus::kCorrupt;
    return result;
  }
  if (bytes.size() < kRecordHeaderBytes) return result;
  ByteReader reader(bytes.subspan(kTypeAt));
  const auto type = reader.Get<std::uint16_t>();
  const auto reserved = reader.Get<std::uint16_t>();
  const std::size_t length = reader.Get<std::uint32_t>();
  const auto sequence = reader.Get<std::uint32_t>();
  const auto checksum = reader.Get<std::uint32_t>();
  if (reserved != 0 || length > kMaxPayloadBytes) {
    result.status = ParseStatus::kCorrupt;
    return result;
  }
  const std::size_t size = kRecordHeaderBytes + length + Padding(length);
  if (bytes.size() < size) return result;
  const ByteSpan payload = bytes.subspan(kRecordHeaderBytes, length);
  const ByteSpan padding = bytes.subspan(kRecordHeaderBytes + length, Padding(length));
  const bool padded = std::all_of(padding.begin(), padding.end(), [](auto b) { return b == 0; });
  if (!padded || ChecksumOf(bytes, payload) != checksum) {
    result.status = ParseStatus::kCorrupt;
    return result;
  }
  result.status = ParseStatus::kRecord;
  result.record = {static_cast<RecordType>(type), sequence, payload};
  result.bytes_used = size;
  return result;
}

}  // namespace livemvs
