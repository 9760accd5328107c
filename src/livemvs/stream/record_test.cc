#include "livemvs/stream/record.h"

#include <gtest/gtest.h>

#include <string>

#include "livemvs/stream/bytes.h"

namespace livemvs {
namespace {

Bytes BytesOf(const std::string& text) { return {text.begin(), text.end()}; }

Bytes RecordWith(const std::string& payload, std::uint32_t sequence = 7) {
  Bytes bytes;
  AppendRecord(RecordType::kMessage, sequence, BytesOf(payload), &bytes);
  return bytes;
}

TEST(Record, IsWhatTheDocumentationSaysByteByByte) {
  // The checksum was computed by another program: Python's zlib.crc32 over bytes 4 to 15 and the
  // payload.
  const Bytes expected = {'L', 'M', 'V', 'R', 9,    0,    0,    0,    3,   0,   0,   0,
                          7,   0,   0,   0,   0xCC, 0xCC, 0xCC, 0xCC, 'a', 'b', 'c', 0};
  Bytes bytes = RecordWith("abc");
  ASSERT_EQ(bytes.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (i >= 16 && i < 20) continue;
    EXPECT_EQ(bytes[i], expected[i]) << "byte " << i;
  }
  constexpr std::uint32_t kChecksum = 0x3781D4D7;
  EXPECT_EQ(ByteReader(ByteSpan(bytes).subspan(16)).Get<std::uint32_t>(), kChecksum);
}

TEST(Record, ComesBackAsItWas) {
  for (std::size_t length : {0, 1, 2, 3, 4, 1000, 100'000}) {
    const std::string payload(length, 'x');
    Bytes bytes = RecordWith(payload);
    EXPECT_EQ(bytes.size() % 4, 0U);
    const std::size_t size = bytes.size();
    bytes.push_back('L');  // the next one's beginning
    const ParseResult result = ParseRecord(bytes);
    ASSERT_EQ(result.status, ParseStatus::kRecord) << length;
    EXPECT_EQ(result.record.type, RecordType::kMessage);
    EXPECT_EQ(result.record.sequence, 7U);
    EXPECT_EQ(Bytes(result.record.payload.begin(), result.record.payload.end()), BytesOf(payload));
    EXPECT_EQ(result.bytes_used, size);
  }
}

TEST(Record, CutAnywhereIsIncomplete) {
  const Bytes bytes = RecordWith("some text");
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_EQ(ParseRecord(ByteSpan(bytes).first(n)).status, ParseStatus::kIncomplete) << n;
  }
}

TEST(Record, AnyBitThatFlipsIsNoticed) {
  const Bytes bytes = RecordWith("some text");
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    Bytes damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    // A longer length looks like a record whose end has not come yet.
    EXPECT_NE(ParseRecord(damaged).status, ParseStatus::kRecord) << "bit " << bit;
  }
}

TEST(Record, ALengthBeyondReasonIsRefusedAtOnce) {
  Bytes bytes = RecordWith("abc");
  bytes[11] = 0xFF;
  EXPECT_EQ(ParseRecord(bytes).status, ParseStatus::kCorrupt);
  EXPECT_THROW(AppendRecord(RecordType::kMessage, 0, Bytes(kMaxPayloadBytes + 1), &bytes),
               std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
