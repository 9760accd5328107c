// 'livemvs scan' as a program that is killed, interrupted, resumed and finished.

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "livemvs/exchange/glb.h"
#include "livemvs/exchange/model.h"
#include "livemvs/io/ply.h"
#include "livemvs/io/tum.h"
#include "livemvs/stream/replay.h"
#include "scan_process.h"

namespace livemvs {
namespace {

using std::chrono::duration;
using testing_support::PauseWatch;
using testing_support::Process;
namespace fs = std::filesystem;

constexpr int kKills = 50;
constexpr double kMostLost = 1;  // [s], as 'livemvs scan' promises

// What the journal must hold, of what the program had shown so long before it died. A machine that
// stood still meanwhile does not count.
void ExpectLittleLost(Process* process,
                      Process::Clock::time_point killed,
                      double stood_still,
                      const fs::path& journal) {
  std::int64_t frames = 0, points = 0;
  for (const Process::Line& line : process->lines()) {
    if (line.text.empty() || line.text[0] != '{') continue;
    if (duration<double>(killed - line.time).count() < kMostLost + stood_still) break;
    const auto json = nlohmann::json::parse(line.text, nullptr, false);
    if (json.is_discarded() || json.at("stage") != "scan") continue;
    frames = json.at("done").get<std::int64_t>();
    points = json.at("points").get<std::int64_t>();
  }
  const Replay replay = ReadJournal(journal).replay;
  EXPECT_EQ(replay.malformed(), 0);
  EXPECT_GE(static_cast<std::int64_t>(replay.frames().size()), frames);
  EXPECT_GE(static_cast<std::int64_t>(replay.Points().size()), points);
}

TEST_F(ScanProcess, KilledAtAnyMomentItLosesASecondAtMostAndGoesOn) {
  Recording();
  std::mt19937 random(20);
  std::uniform_real_distribution<double> moment(0.02, 1.0);
  int killed_in_time = 0, resumed = 0;
  std::size_t least_points = 1'000'000, most_points = 0;
  // What is lost and found again is the film; a mesh each time would take longer than all else.
  std::vector<std::string> resume_command = ResumeCommand();
  resume_command.push_back("--no-mesh");
  for (int run = 0; run < kKills; ++run) {
    SCOPED_TRACE("run " + std::to_string(run));
    fs::remove_all(scan_);
    // Half of the time at its own pace, killed late, half of it at full speed.
    const bool paced = run % 2 == 0;
    Process process(
        ScanCommand(paced ? std::vector<std::string>{"--realtime"} : std::vector<std::string>{}));
    // Most are given the time to begin, however long that takes here.
    PauseWatch pauses;
    if (run % 7 != 0) {
      ASSERT_TRUE(WaitForJournal(0, 0)) << process.text();
    }
    std::this_thread::sleep_for(duration<double>(moment(random) * (paced ? 1.8 : 0.2)));
    const auto killed = Process::Clock::now();
    process.Kill(SIGKILL);
    killed_in_time += process.Wait() == 128 + SIGKILL ? 1 : 0;
    std::error_code error;
    if (fs::file_size(scan_ / "journal.lmv", error) == 0 || error) continue;  // had not begun
    ExpectLittleLost(&process, killed, pauses.Total(), scan_ / "journal.lmv");
    if (run % 5 == 0) {  // killed again while it goes on
      Process again(resume_command);
      std::this_thread::sleep_for(duration<double>(0.3 * moment(random)));
      again.Kill(SIGKILL);
      again.Wait();
    }
    Process resume(resume_command);
    ASSERT_EQ(resume.Wait(), 0) << resume.text();
    ++resumed;
    // Frames that a paced run dropped, many on a busy machine, do not come back.
    const std::size_t points = ReadPly(scan_ / "cloud.ply").cloud.size();
    EXPECT_GT(points, 0U);
    if (!paced) {
      least_points = std::min(least_points, points);
      most_points = std::max(most_points, points);
      ExpectWhole();
    }
    if (HasFailure()) break;
  }
  std::printf("%d of %d killed before their end, %d resumed, %zu to %zu points\n",
              killed_in_time,
              kKills,
              resumed,
              least_points,
              most_points);
  EXPECT_GT(killed_in_time, kKills / 2);
  EXPECT_GT(resumed, kKills / 2);
  // Wherever it was cut, about the same cloud.
  EXPECT_GT(static_cast<double>(least_points), 0.7 * static_cast<double>(most_points));
}

TEST_F(ScanProcess, SigtermFinishesItCleanly) {
  for (const int signal : {SIGTERM, SIGINT}) {
    // On a busy machine the signal may come too late, after the end.
    int code = 0;
    std::string text;
    for (int attempt = 0; attempt < 5 && code != 130; ++attempt) {
      fs::remove_all(scan_);
      Process process(ScanCommand({"--realtime"}));
      ASSERT_TRUE(WaitForJournal(15, 10)) << process.text();
      process.Kill(signal);
      code = process.Wait();
      text = process.text();
    }
    EXPECT_EQ(code, 130) << text;
    EXPECT_NE(text.find("--resume"), std::string::npos) << text;
    EXPECT_GT(ReadPly(scan_ / "cloud.ply").cloud.size(), 0U);
    const Replay replay = ReadJournal(scan_ / "journal.lmv").replay;
    ASSERT_TRUE(replay.end());
    EXPECT_EQ(replay.end()->reason, EndMessage::kInterrupted);
    EXPECT_LT(replay.frames().size(), static_cast<std::size_t>(kFrames));
    EXPECT_GT(replay.frames().size(), 10U);
  }
}

TEST_F(ScanProcess, EndsWithAMeshAndShowsHowFarItIs) {
  Process process(ScanCommand());
  ASSERT_EQ(process.Wait(), 0) << process.text();
  EXPECT_NE(process.text().find("mesh: points"), std::string::npos) << process.text();
  const ExchangeModel model = ReadGlb(scan_ / "model.glb");
  EXPECT_GT(model.faces.size(), 500U);
  EXPECT_TRUE(model.has_colors);
  // In the same world as the cloud.
  const Extent mesh = ExtentOf(model);
  const Extent cloud = ExtentOf(MakeExchangeModel(ReadPly(scan_ / "cloud.ply"), "cloud"));
  const double margin = 0.1 * cloud.LongestSide();
  EXPECT_GT(mesh.LongestSide(), margin);
  EXPECT_GT((mesh.min - cloud.min).minCoeff(), -margin);
  EXPECT_GT((cloud.max - mesh.max).minCoeff(), -margin);
}

TEST_F(ScanProcess, ASignalWhileTheMeshIsMadeLeavesItOutAndKeepsTheRest) {
  for (const int signal : {SIGINT, SIGTERM}) {
    // On a busy machine the signal may come too late, after the end.
    int code = 0;
    std::string text;
    for (int attempt = 0; attempt < 5 && code != 130; ++attempt) {
      fs::remove_all(scan_);
      Process process(ScanCommand());
      ASSERT_TRUE(process.WaitFor("mesh: ")) << process.text();
      process.Kill(signal);
      code = process.Wait();
      text = process.text();
    }
    EXPECT_EQ(code, 130) << text;
    EXPECT_NE(text.find("livemvs mesh " + scan_.string() + " -o"), std::string::npos) << text;
    ExpectWhole();
    EXPECT_EQ(ReadJournal(scan_ / "journal.lmv").replay.end()->reason, EndMessage::kFinished);
    EXPECT_FALSE(fs::exists(scan_ / "model.glb"));
    // Later, as the message says.
    Process later({LIVEMVS_PROGRAM, "mesh", scan_.string(), "-o", (scan_ / "model.glb").string()});
    EXPECT_EQ(later.Wait(), 0) << later.text();
    EXPECT_GT(ReadGlb(scan_ / "model.glb").faces.size(), 500U);
  }
}

TEST_F(ScanProcess, TheSignalThatEndsFilmingDoesNotEndTheMeshButAnotherDoes) {
  for (const bool twice : {false, true}) {
    bool left_out = false;
    const int attempts = twice ? 5 : 1;  // the second signal may come too late
    for (int attempt = 0; attempt < attempts && !left_out; ++attempt) {
      fs::remove_all(scan_);
      Process process(ScanCommand({"--realtime"}));
      ASSERT_TRUE(WaitForJournal(40, 10)) << process.text();
      process.Kill(SIGINT);
      ASSERT_TRUE(process.WaitFor("mesh: ")) << process.text();
      if (twice) process.Kill(SIGINT);
      EXPECT_EQ(process.Wait(), 130) << process.text();
      left_out = process.text().find("mesh was left out") != std::string::npos;
      EXPECT_EQ(fs::exists(scan_ / "model.glb"), !left_out) << process.text();
      EXPECT_GT(ReadPly(scan_ / "cloud.ply").cloud.size(), 0U);
    }
    EXPECT_EQ(left_out, twice);
  }
}

TEST_F(ScanProcess, AScanThatIsDoneIsNotTouchedByAnotherAndCanBeFinishedAgain) {
  Process first(ScanCommand());
  ASSERT_EQ(first.Wait(), 0) << first.text();
  ExpectWhole();
  Process second(ScanCommand());  // to the same folder
  EXPECT_EQ(second.Wait(), 3);
  EXPECT_NE(second.text().find("holds a scan already"), std::string::npos) << second.text();
  fs::remove(scan_ / "cloud.ply");
  Process resume(ResumeCommand());
  EXPECT_EQ(resume.Wait(), 0) << resume.text();
  ExpectWhole();
}

TEST_F(ScanProcess, FinishWritesWhatTheJournalHolds) {
  Process process(ScanCommand({"--realtime"}));
  ASSERT_TRUE(WaitForJournal(15, 10)) << process.text();
  process.Kill(SIGKILL);
  process.Wait();
  const std::size_t frames = ReadJournal(scan_ / "journal.lmv").replay.frames().size();
  std::vector<std::string> command = ResumeCommand();
  command.emplace_back("--finish");
  Process finish(command);
  EXPECT_EQ(finish.Wait(), 0) << finish.text();
  EXPECT_EQ(ReadTumTrajectory(scan_ / "poses.txt", PoseConvention::kAuto).size(), frames);
  EXPECT_GT(ReadPly(scan_ / "cloud.ply").cloud.size(), 0U);
}

TEST_F(ScanProcess, TwoProgramsDoNotWriteOneScan) {
  Process process(ScanCommand({"--realtime"}));
  ASSERT_TRUE(WaitForJournal(0, 0)) << process.text();
  process.Kill(SIGSTOP);  // so that it is not done before the other has begun
  Process other(ResumeCommand());
  EXPECT_EQ(other.Wait(), 1) << other.text();
  process.Kill(SIGCONT);
  EXPECT_NE(other.text().find("another program"), std::string::npos) << other.text();
  EXPECT_EQ(process.Wait(), 0) << process.text();
}

TEST_F(ScanProcess, AScanThatWasCutOffBeforeItBeganIsNone) {
  fs::create_directories(scan_);
  std::fclose(std::fopen((scan_ / "journal.lmv").c_str(), "wb"));
  Process process(ScanCommand());
  EXPECT_EQ(process.Wait(), 0) << process.text();
  ExpectWhole();
}

TEST_F(ScanProcess, AJournalOfAnotherKindIsRefusedByName) {
  fs::create_directories(scan_);
  for (const char* bytes : {"", "ply\nformat ascii 1.0\n", "LMVR"}) {
    std::FILE* file = std::fopen((scan_ / "journal.lmv").c_str(), "wb");
    std::fputs(bytes, file);
    std::fclose(file);
    Process resume(ResumeCommand());
    EXPECT_EQ(resume.Wait(), 3) << resume.text();
    EXPECT_NE(resume.text().find("journal.lmv"), std::string::npos) << resume.text();
  }
  // A session that does not say how the scan was made.
  std::vector<std::uint8_t> record;
  AppendRecord(RecordType::kSession, 0, Encode(SessionMessage{.json = "[[["}), &record);
  std::FILE* file = std::fopen((scan_ / "journal.lmv").c_str(), "wb");
  std::fwrite(record.data(), 1, record.size(), file);
  std::fclose(file);
  Process resume(ResumeCommand());
  EXPECT_EQ(resume.Wait(), 3) << resume.text();
}

}  // namespace
}  // namespace livemvs
