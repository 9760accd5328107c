// Hostile bytes for the readers of the scan's stream. The first byte chooses how the rest is used:
// as a stream, or as the payload of a record with a valid checksum, which a stream made by chance
// never has.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "livemvs/stream/messages.h"
#include "livemvs/stream/point_codec.h"
#include "livemvs/stream/record.h"
#include "livemvs/stream/replay.h"

namespace livemvs {
namespace {

using Bytes = std::vector<std::uint8_t>;

void Require(bool condition) {
  if (!condition) std::abort();
}

// What was decoded must encode to something that decodes again to the same bytes.
template <typename Decode, typename EncodeAgain>
void RoundTrip(std::span<const std::uint8_t> payload, Decode decode, EncodeAgain encode) {
  const auto first = decode(payload);
  if (!first) return;
  const Bytes bytes = encode(*first);
  const auto second = decode(bytes);
  Require(second.has_value());
}

void DecodeAll(std::span<const std::uint8_t> payload) {
  const auto encode = [](const auto& message) { return Encode(message); };
  RoundTrip(payload, DecodeSession, encode);
  RoundTrip(payload, DecodeCamera, encode);
  RoundTrip(payload, DecodeScene, encode);
  RoundTrip(payload, DecodeFrame, encode);
  RoundTrip(payload, DecodeText, encode);
  RoundTrip(payload, DecodeEnd, encode);
  RoundTrip(payload, DecodeStatistics, EncodeStatistics);
  RoundTrip(payload, DecodePoints, [](const PointsMessage& m) {
    for (const Point& p : m.points) Require(p.position.allFinite() && p.normal.allFinite());
    return EncodePoints(m.frame, m.first_id, m.points);
  });
  RoundTrip(payload, DecodeRefinedPoints, [](const PointsMessage& m) {
    return EncodeRefinedPoints(m.frame, m.ids, m.points);
  });
  RoundTrip(payload, DecodeRemovedPoints, [](const std::vector<std::uint32_t>& ids) {
    return EncodeRemovedPoints(ids);
  });
}

Replay ReplayAll(std::span<const std::uint8_t> bytes) {
  Replay replay;
  while (true) {
    const ParseResult result = ParseRecord(bytes);
    if (result.status != ParseStatus::kRecord) break;
    Require(result.bytes_used <= bytes.size());
    replay.Apply(result.record);
    bytes = bytes.subspan(result.bytes_used);
  }
  Require(replay.Points().size() <= replay.next_id());
  return replay;
}

// Cuts the bytes into payloads: a byte for the type, one for the length in steps of 4.
Bytes MakeStream(std::span<const std::uint8_t> bytes) {
  Bytes stream;
  std::uint32_t sequence = 0;
  while (bytes.size() >= 2) {
    const auto type = static_cast<RecordType>(bytes[0] % 12);
    const std::size_t length = std::min<std::size_t>(4 * bytes[1], bytes.size() - 2);
    AppendRecord(type, sequence++, bytes.subspan(2, length), &stream);
    bytes = bytes.subspan(2 + length);
  }
  return stream;
}

}  // namespace
}  // namespace livemvs

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  switch (data[0] % 3) {
    case 0:
      livemvs::ReplayAll(bytes);
      break;
    case 1:
      livemvs::ReplayAll(livemvs::MakeStream(bytes));
      break;
    default:
      livemvs::DecodeAll(bytes);
  }
  return 0;
}
