#include "viewer/stream_log.h"

#include <gtest/gtest.h>

#include <thread>

namespace livemvs::viewer {
namespace {

std::vector<std::uint8_t> Payload(std::size_t size, std::uint8_t value) {
  return std::vector<std::uint8_t>(size, value);
}

Record Parsed(const SharedBytes& bytes) {
  const ParseResult result = ParseRecord(*bytes);
  EXPECT_EQ(result.status, ParseStatus::kRecord);
  EXPECT_EQ(result.bytes_used, bytes->size());
  return result.record;
}

TEST(StreamLog, NumbersRecordsAndHandsThemOutOnce) {
  StreamLog log;
  for (std::uint8_t i = 0; i < 5; ++i) log.Append(RecordType::kMessage, Payload(100, i));
  StreamLog::Cursor cursor;
  const auto first = log.Take(&cursor, 250);
  ASSERT_EQ(first.size(), 3U);  // until 250 bytes are reached
  const auto rest = log.Take(&cursor, 10000);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_TRUE(log.Take(&cursor, 10000).empty());
  std::uint32_t number = 0;
  for (const auto& list : {first, rest}) {
    for (const SharedBytes& bytes : list) {
      const Record record = Parsed(bytes);
      EXPECT_EQ(record.sequence, number);
      EXPECT_EQ(record.payload[0], number++);
    }
  }
  EXPECT_EQ(log.size(), 5U);
  EXPECT_GT(log.bytes(), 500U);
}

TEST(StreamLog, OnlyTheLatestPictureIsKeptAndNoneForWhoIsBehind) {
  StreamLog log;
  StreamLog::Cursor cursor;
  for (std::uint8_t i = 0; i < 9; ++i) log.SetPreview(Payload(1000, i));
  log.Append(RecordType::kMessage, Payload(10, 0));
  // The record first, without the picture; the picture once there is nothing else.
  auto taken = log.Take(&cursor, 100000);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(Parsed(taken[0]).type, RecordType::kMessage);
  taken = log.Take(&cursor, 100000);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(Parsed(taken[0]).type, kRecordPreview);
  EXPECT_EQ(Parsed(taken[0]).sequence, kUnnumbered);
  EXPECT_EQ(Parsed(taken[0]).payload[0], 8);
  EXPECT_TRUE(log.Take(&cursor, 100000).empty());
  log.SetLive("{}");
  log.SetLive("{\"a\":1}");
  taken = log.Take(&cursor, 100000);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(Parsed(taken[0]).type, kRecordLive);
}

TEST(StreamLog, TellsOfChangesUntilToldNotTo) {
  StreamLog log;
  int changes = 0;
  log.SetListener([&] { ++changes; });
  log.Append(RecordType::kMessage, {});
  log.SetPreview(Payload(1, 0));
  log.SetLive("{}");
  EXPECT_EQ(changes, 3);
  log.SetListener({});
  log.Append(RecordType::kMessage, {});
  EXPECT_EQ(changes, 3);
}

TEST(StreamLog, ServesReadersBesideItsWriter) {
  StreamLog log;
  constexpr std::uint32_t kRecords = 5000;
  const auto read = [&] {
    StreamLog::Cursor cursor;
    std::uint32_t number = 0;
    while (number < kRecords) {
      for (const SharedBytes& bytes : log.Take(&cursor, 4096)) {
        const ParseResult result = ParseRecord(*bytes);
        if (result.record.sequence == kUnnumbered) continue;
        if (result.record.sequence != number++) return false;
      }
    }
    return true;
  };
  bool good[2] = {false, false};
  std::thread a([&] { good[0] = read(); }), b([&] { good[1] = read(); });
  for (std::uint32_t i = 0; i < kRecords; ++i) {
    log.Append(RecordType::kMessage, Payload(40, 1));
    if (i % 10 == 0) log.SetPreview(Payload(100, 2));
  }
  a.join();
  b.join();
  EXPECT_TRUE(good[0]);
  EXPECT_TRUE(good[1]);
}

TEST(StreamLog, StreamsHaveNamesOfTheirOwn) {
  EXPECT_NE(StreamLog().session(), StreamLog().session());
  EXPECT_EQ(StreamLog().session().size(), 16U);
}

}  // namespace
}  // namespace livemvs::viewer
