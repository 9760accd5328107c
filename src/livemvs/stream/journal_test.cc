#include "livemvs/stream/journal.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "livemvs/core/error.h"
#include "livemvs/stream/bytes.h"
#include "livemvs/stream/replay.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

class JournalTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("Journal_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    path_ = folder_ / "journal.lmv";
  }
  void TearDown() override { fs::remove_all(folder_); }

  Bytes ReadFile() const {
    std::ifstream in(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void WriteFile(ByteSpan bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }

  fs::path folder_, path_;
};

Point PointAt(float x) {
  Point p;
  p.position = {x, 2 * x, 3};
  p.normal = {0, 0, 1};
  p.sigma = 0.01F;
  p.views = 9;
  return p;
}

// A small scan: 4 frames with a point each.
void WriteScan(JournalWriter* journal, int frames = 4) {
  journal->Append(RecordType::kSession, Encode(SessionMessage{.json = "{}"}));
  for (int i = 0; i < frames; ++i) {
    FrameMessage frame;
    frame.index = i;
    frame.timestamp = 0.04 * i;
    frame.tracking_state = 1;
    frame.cam_from_world = Rigid3d{};
    journal->Append(RecordType::kFrame, Encode(frame));
    const Point point = PointAt(static_cast<float>(i));
    journal->Append(RecordType::kPoints,
                    EncodePoints(i, static_cast<std::uint32_t>(i), {&point, 1}));
  }
}

TEST_F(JournalTest, ReplaysWhatWasWritten) {
  {
    JournalWriter journal(path_);
    WriteScan(&journal);
    const Point better = PointAt(20);
    const std::uint32_t refined[] = {1}, removed[] = {2};
    journal.Append(RecordType::kPointsRefined, EncodeRefinedPoints(4, refined, {&better, 1}));
    journal.Append(RecordType::kPointsRemoved, EncodeRemovedPoints(removed));
    journal.Append(RecordType::kStatistics, EncodeStatistics(R"({"a":1})"));
    journal.Append(static_cast<RecordType>(999), {});  // of a later version
    journal.Append(RecordType::kEnd, Encode(EndMessage{EndMessage::kFinished, 4, 3, ""}));
  }
  const JournalContents contents = ReadJournal(path_);
  EXPECT_EQ(contents.tail, JournalReader::Tail::kClean);
  EXPECT_EQ(contents.valid_bytes, static_cast<std::int64_t>(fs::file_size(path_)));
  EXPECT_EQ(contents.next_sequence, 14U);
  const Replay& replay = contents.replay;
  EXPECT_EQ(replay.malformed(), 0);
  EXPECT_EQ(replay.frames().size(), 4U);
  EXPECT_EQ(replay.statistics(), R"({"a":1})");
  ASSERT_TRUE(replay.end());
  EXPECT_EQ(replay.next_id(), 4U);
  const PointCloud points = replay.Points();
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[0].position, PointAt(0).position);
  EXPECT_EQ(points[1].position, PointAt(20).position);
  EXPECT_EQ(points[2].position, PointAt(3).position);
}

TEST_F(JournalTest, CutAtEveryByteGivesTheRecordsBefore) {
  {
    JournalWriter journal(path_);
    WriteScan(&journal, 2);
  }
  const Bytes whole = ReadFile();
  std::vector<std::size_t> ends;
  for (std::size_t at = 0; at < whole.size();) {
    at += ParseRecord(ByteSpan(whole).subspan(at)).bytes_used;
    ends.push_back(at);
  }
  ASSERT_EQ(ends.size(), 5U);
  for (std::size_t n = 0; n <= whole.size(); ++n) {
    WriteFile(ByteSpan(whole).first(n));
    JournalReader reader(path_);
    std::size_t records = 0;
    while (reader.Next()) ++records;
    const auto expected =
        static_cast<std::size_t>(std::upper_bound(ends.begin(), ends.end(), n) - ends.begin());
    ASSERT_EQ(records, expected) << "cut at byte " << n;
    const std::size_t valid = expected > 0 ? ends[expected - 1] : 0;
    EXPECT_EQ(reader.valid_bytes(), static_cast<std::int64_t>(valid));
    EXPECT_EQ(reader.tail(), valid == n ? JournalReader::Tail::kClean : JournalReader::Tail::kTorn);
    if (expected == 0) continue;
    // Whatever was torn, the scan goes on behind it.
    JournalWriter journal(path_, reader.valid_bytes(), reader.next_sequence());
    journal.Append(RecordType::kMessage, Encode(TextMessage{MessageLevel::kInfo, "resumed"}));
    journal.Flush();
    JournalReader again(path_);
    std::size_t after = 0;
    while (again.Next()) ++after;
    ASSERT_EQ(after, expected + 1) << "cut at byte " << n;
    EXPECT_EQ(again.tail(), JournalReader::Tail::kClean);
  }
}

TEST_F(JournalTest, DamageInAnyByteGivesTheRecordsBefore) {
  {
    JournalWriter journal(path_);
    WriteScan(&journal, 2);
  }
  const Bytes whole = ReadFile();
  for (std::size_t at = 4; at < whole.size(); ++at) {
    Bytes damaged = whole;
    damaged[at] ^= 0x10;
    WriteFile(damaged);
    JournalReader reader(path_);
    while (reader.Next()) continue;
    EXPECT_LE(reader.valid_bytes(), static_cast<std::int64_t>(at));
    EXPECT_NE(reader.tail(), JournalReader::Tail::kClean) << "byte " << at;
  }
}

TEST_F(JournalTest, ARecordThatIsMissingIsNoticed) {
  Bytes bytes;
  AppendRecord(RecordType::kSession, 0, Encode(SessionMessage{}), &bytes);
  AppendRecord(RecordType::kMessage, 2, Encode(TextMessage{}), &bytes);
  WriteFile(bytes);
  JournalReader reader(path_);
  EXPECT_TRUE(reader.Next());
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.tail(), JournalReader::Tail::kCorrupt);
}

TEST_F(JournalTest, AGrowingJournalCanBeFollowed) {
  JournalWriter journal(path_);
  WriteScan(&journal, 1);
  journal.Flush();
  JournalReader reader(path_);
  int records = 0;
  while (reader.Next()) ++records;
  EXPECT_EQ(records, 3);
  journal.Append(RecordType::kMessage, Encode(TextMessage{}));
  EXPECT_FALSE(reader.Next()) << "not flushed yet";
  journal.Flush();
  EXPECT_TRUE(reader.Next());
  EXPECT_FALSE(reader.Next());
}

TEST_F(JournalTest, OtherFilesAreRefusedByName) {
  WriteFile(ByteSpan{});
  EXPECT_THROW(ReadJournal(path_), Error);
  const std::string text = "ply\nformat ascii 1.0\n";
  WriteFile(Bytes(text.begin(), text.end()));
  try {
    ReadJournal(path_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    EXPECT_NE(std::string(error.what()).find(path_.string()), std::string::npos);
  }
  EXPECT_THROW(ReadJournal(folder_ / "absent"), Error);
  EXPECT_THROW(ReadJournal(folder_), Error);
  Bytes later;
  AppendRecord(RecordType::kSession, 0, Encode(SessionMessage{.version = 99}), &later);
  WriteFile(later);
  EXPECT_THROW(ReadJournal(path_), Error);
}

TEST_F(JournalTest, AnExistingFileIsNotReplaced) {
  WriteFile(Bytes{1, 2, 3});
  EXPECT_THROW(JournalWriter{path_}, Error);
  EXPECT_EQ(ReadFile(), (Bytes{1, 2, 3}));
}

TEST_F(JournalTest, TwoWritersDoNotGetInEachOthersWay) {
  JournalWriter journal(path_);
  WriteScan(&journal);
  journal.Flush();
  EXPECT_THROW(JournalWriter(path_, 0, 0), Error);
  EXPECT_EQ(ReadJournal(path_).replay.frames().size(), 4U) << "nothing was cut off";
}

TEST_F(JournalTest, AFullDiskLeavesWholeRecords) {
  // Files beyond a limit fail with EFBIG, in the middle of a write, as they do on a full disk.
  constexpr rlim_t kLimit = 50'000;
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const rlimit limit{kLimit, old_limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::string problem;
  {
    JournalWriter journal(path_);
    try {
      for (int i = 0; i < 1000; ++i) {
        WriteScan(&journal, 3);
        if (i % 10 == 0) journal.Flush();
      }
    } catch (const Error& error) {
      problem = error.what();
      EXPECT_EQ(error.kind(), ErrorKind::kOutOfResource);
    }
    EXPECT_TRUE(journal.failed());
    EXPECT_THROW(journal.Append(RecordType::kMessage, {}), Error);
  }
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_NE(problem.find("disk full"), std::string::npos) << problem;
  JournalReader reader(path_);
  int records = 0;
  while (reader.Next()) ++records;
  EXPECT_GT(records, 100);
  EXPECT_EQ(reader.tail(), JournalReader::Tail::kClean);
}

}  // namespace
}  // namespace livemvs
