#include "livemvs/io/seed_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "livemvs/io/media_test_util.h"

namespace livemvs {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kHeader = 24, kRecord = 28;

class SeedTraceTest : public MediaTest {
 protected:
  static std::vector<SeedRecord> ThreeSeeds() {
    return {{.birth_frame = 0,
             .x = 12,
             .y = 7.25F,
             .end_frame = 9,
             .fate = Fate::kConverged,
             .views = 400,
             .depth = 1.5F,
             .sigma = 0.01F},
            {.birth_frame = 3, .x = -0.5F, .y = 0, .end_frame = 3, .fate = Fate::kLeftInterval},
            {.birth_frame = 4'000'000'000, .end_frame = 4'000'000'001, .fate = Fate::kAlive}};
  }
  // The bytes of a trace of ThreeSeeds().
  std::string Bytes() {
    SeedTraceWriter writer(folder_ / "good.trace");
    for (const SeedRecord& record : ThreeSeeds()) writer.Write(record);
    writer.Finish();
    return ReadBytes(folder_ / "good.trace");
  }
  std::string ErrorOf(const std::string& bytes) {
    WriteBytes(folder_ / "bad.trace", bytes);
    const std::string message = BadInputMessage([&] { ReadSeedTrace(folder_ / "bad.trace"); });
    EXPECT_THAT(message, HasSubstr("bad.trace"));
    return message;
  }
  // What is said of a trace in which a field of the second seed was replaced.
  template <typename T>
  std::string ErrorWith(std::size_t offset, T value) {
    std::string bytes = Bytes();
    std::memcpy(bytes.data() + kHeader + kRecord + offset, &value, sizeof(value));
    const std::string message = ErrorOf(bytes);
    EXPECT_THAT(message, HasSubstr("seed 1: "));
    return message;
  }
};

TEST_F(SeedTraceTest, FatesHaveTheNumbersOfTheFormat) {
  constexpr std::size_t kFate = 26;
  const Fate fates[] = {Fate::kAlive,
                        Fate::kConverged,
                        Fate::kOutlier,
                        Fate::kAged,
                        Fate::kUnseen,
                        Fate::kLeftInterval,
                        Fate::kOneSided,
                        Fate::kTakenOut};
  SeedTraceWriter writer(folder_ / "fates.trace");
  for (const Fate fate : fates) writer.Write({.fate = fate, .depth = 1});
  writer.Finish();
  const std::string bytes = ReadBytes(folder_ / "fates.trace");
  const std::vector<SeedRecord> read = ReadSeedTrace(folder_ / "fates.trace");
  ASSERT_EQ(read.size(), std::size(fates));
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(bytes[kHeader + i * kRecord + kFate], static_cast<char>(i));
    EXPECT_EQ(read[i].fate, fates[i]);
  }
}

TEST_F(SeedTraceTest, ReadsBackWhatWasWritten) {
  EXPECT_EQ(Bytes().size(), kHeader + 3 * kRecord);
  const std::vector<SeedRecord> read = ReadSeedTrace(folder_ / "good.trace");
  const std::vector<SeedRecord> written = ThreeSeeds();
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].birth_frame, written[i].birth_frame);
    EXPECT_EQ(read[i].end_frame, written[i].end_frame);
    EXPECT_EQ(read[i].x, written[i].x);
    EXPECT_EQ(read[i].y, written[i].y);
    EXPECT_EQ(read[i].fate, written[i].fate);
    EXPECT_EQ(read[i].views, written[i].views);
    EXPECT_EQ(read[i].depth, written[i].depth);
    EXPECT_EQ(read[i].sigma, written[i].sigma);
  }
}

TEST_F(SeedTraceTest, FatesMayChangeUntilTheEnd) {
  const std::string before = Bytes();
  SeedTraceWriter writer(folder_ / "changed.trace");
  const std::vector<SeedRecord> seeds = ThreeSeeds();
  writer.Write(seeds[0]);
  writer.Write(seeds[1]);
  writer.SetFate(0, Fate::kTakenOut);
  writer.Write(seeds[2]);
  EXPECT_THROW(writer.SetFate(3, Fate::kTakenOut), std::invalid_argument);
  writer.Finish();
  std::string expected = before;
  expected[kHeader + 26] = static_cast<char>(Fate::kTakenOut);
  EXPECT_EQ(ReadBytes(folder_ / "changed.trace"), expected);
}

TEST_F(SeedTraceTest, AppearsWholeOrNotAtAll) {
  {
    SeedTraceWriter writer(folder_ / "unfinished.trace");
    writer.Write(ThreeSeeds()[0]);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "unfinished.trace"));
}

TEST_F(SeedTraceTest, RefusesOtherFiles) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("not a seed trace"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\nelement vertex 0\nend_header\n"),
              HasSubstr("not a seed trace"));
  EXPECT_THAT(ErrorOf(Bytes().substr(0, kHeader - 1)), HasSubstr("not a seed trace"));
  std::string newer = Bytes();
  newer[8] = 3;
  EXPECT_THAT(ErrorOf(newer), HasSubstr("version 3"));
  BadInputMessage([&] { ReadSeedTrace(folder_ / "absent.trace"); });
  BadInputMessage([&] { ReadSeedTrace(folder_); });
}

TEST_F(SeedTraceTest, RefusesCountsThatTheFileCannotHold) {
  const std::string good = Bytes();
  for (std::size_t size = kHeader; size < good.size(); ++size) {
    EXPECT_THAT(ErrorOf(good.substr(0, size)), HasSubstr("damaged or cut"));
  }
  EXPECT_THAT(ErrorOf(good + "x"), HasSubstr("damaged or cut"));
  // Taken at its word, this count would need more memory than there is; times the size of a
  // record, it overflows to the right number of bytes.
  for (const std::uint64_t count : {std::uint64_t{1} << 40, ~std::uint64_t{0}, std::uint64_t{0}}) {
    std::string bytes = good;
    std::memcpy(bytes.data() + 16, &count, sizeof(count));
    EXPECT_THAT(ErrorOf(bytes), HasSubstr("damaged or cut"));
  }
}

TEST_F(SeedTraceTest, RefusesImpossibleNumbers) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float bad : {kNan, kInfinity, -kInfinity}) {
    EXPECT_THAT(ErrorWith(8, bad), HasSubstr("pixel"));
    EXPECT_THAT(ErrorWith(12, bad), HasSubstr("pixel"));
    EXPECT_THAT(ErrorWith(16, bad), HasSubstr("depth"));
    EXPECT_THAT(ErrorWith(20, bad), HasSubstr("sigma"));
  }
  EXPECT_THAT(ErrorWith(16, -1.F), HasSubstr("depth"));
  EXPECT_THAT(ErrorWith(20, -1.F), HasSubstr("sigma"));
  EXPECT_THAT(ErrorWith(26, static_cast<std::uint8_t>(Fate::kRemoved)), HasSubstr("fate"));
  EXPECT_THAT(ErrorWith(26, std::uint8_t{255}), HasSubstr("fate"));
  EXPECT_THAT(ErrorWith(26, static_cast<std::uint8_t>(Fate::kConverged)), HasSubstr("no depth"));
  EXPECT_THAT(ErrorWith(4, std::uint32_t{2}), HasSubstr("before its birth"));
}

TEST_F(SeedTraceTest, TheWriterRefusesWhatTheReaderWould) {
  SeedTraceWriter writer(folder_ / "a.trace");
  EXPECT_THROW(writer.Write({.birth_frame = -1}), std::invalid_argument);
  EXPECT_THROW(writer.Write({.end_frame = std::int64_t{1} << 32}), std::invalid_argument);
  EXPECT_THROW(writer.Write({.depth = NAN}), std::invalid_argument);
  EXPECT_THROW(writer.Write({.birth_frame = 2, .end_frame = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace livemvs
