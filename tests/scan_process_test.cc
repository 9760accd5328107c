// 'livemvs scan' as a program that is killed, interrupted, or runs out of disk.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "livemvs/io/ply.h"
#include "livemvs/io/tum.h"
#include "livemvs/io/video_source.h"
#include "livemvs/stream/replay.h"
#include "livemvs/synth/export.h"
#include "process.h"

namespace livemvs {
namespace {

using std::chrono::duration;
using std::chrono::milliseconds;
using testing_support::Process;
namespace fs = std::filesystem;

constexpr int kFrames = 60;  // 2 s
constexpr int kKills = 50;
constexpr double kMostLost = 1;  // [s], as 'livemvs scan' promises

// A short recording, made once.
fs::path Recording() {
  static const fs::path folder = [] {
    const fs::path path = fs::path(::testing::TempDir()) / "scan_process_recording";
    fs::remove_all(path);
    SyntheticScene scene({.name = "table"});
    SequenceOptions sequence;
    sequence.path = DefaultPath("table");
    sequence.path.frames = kFrames;
    sequence.path.arc_deg = 40;
    sequence.camera = SyntheticCamera(320, 240);
    sequence.samples_per_pixel = 1;
    sequence.ground_truth = false;
    ExportOptions options;
    options.folder = path;
    options.preset = "veryfast";
    options.mesh = false;
    ExportSequence(scene, sequence, options);
    return path;
  }();
  return folder;
}

class ScanProcess : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("scan_process_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    scan_ = folder_ / "scan";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::vector<std::string> ScanCommand(std::vector<std::string> more = {}) const {
    std::vector<std::string> command = {LIVEMVS_PROGRAM,
                                        "scan",
                                        "--data",
                                        Recording().string(),
                                        "-o",
                                        scan_.string(),
                                        "--seeds",
                                        "3000",
                                        "--threads",
                                        "2",
                                        "--progress",
                                        "json"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  std::vector<std::string> ResumeCommand() const {
    return {LIVEMVS_PROGRAM, "scan", "--resume", scan_.string(), "--threads", "2"};
  }

  // All frames are there once, and the results can be read.
  void ExpectWhole() const {
    const JournalContents contents = ReadJournal(scan_ / "journal.lmv");
    EXPECT_EQ(contents.tail, JournalReader::Tail::kClean);
    EXPECT_EQ(contents.replay.malformed(), 0);
    ASSERT_EQ(contents.replay.frames().size(), static_cast<std::size_t>(kFrames));
    for (int i = 0; i < kFrames; ++i) EXPECT_EQ(contents.replay.frames()[i].index, i);
    EXPECT_GT(ReadPly(scan_ / "cloud.ply").cloud.size(), 300U);
    EXPECT_EQ(ReadTumTrajectory(scan_ / "poses.txt", PoseConvention::kAuto).size(),
              static_cast<std::size_t>(kFrames));
    EXPECT_TRUE(fs::exists(scan_ / "statistics.json"));
    EXPECT_TRUE(fs::exists(scan_ / "camera.yaml"));
  }

  fs::path folder_, scan_;
};

// What the journal must hold, of what the program had shown so long before it died.
void ExpectLittleLost(Process* process,
                      Process::Clock::time_point killed,
                      const fs::path& journal) {
  std::int64_t frames = 0, points = 0;
  for (const Process::Line& line : process->lines()) {
    if (line.text.empty() || line.text[0] != '{') continue;
    if (duration<double>(killed - line.time).count() < kMostLost) break;
    const auto json = nlohmann::json::parse(line.text, nullptr, false);
    if (json.is_discarded()) continue;
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
  for (int run = 0; run < kKills; ++run) {
    SCOPED_TRACE("run " + std::to_string(run));
    fs::remove_all(scan_);
    // Half of the time at its own pace, killed late, half of it at full speed.
    const bool paced = run % 2 == 0;
    Process process(
        ScanCommand(paced ? std::vector<std::string>{"--realtime"} : std::vector<std::string>{}));
    std::this_thread::sleep_for(duration<double>(moment(random) * (paced ? 1.9 : 0.3)));
    const auto killed = Process::Clock::now();
    process.Kill(SIGKILL);
    killed_in_time += process.Wait() == 128 + SIGKILL ? 1 : 0;
    std::error_code error;
    if (fs::file_size(scan_ / "journal.lmv", error) == 0 || error) continue;  // had not begun
    ExpectLittleLost(&process, killed, scan_ / "journal.lmv");
    if (run % 5 == 0) {  // killed again while it goes on
      Process again(ResumeCommand());
      std::this_thread::sleep_for(duration<double>(0.3 * moment(random)));
      again.Kill(SIGKILL);
      again.Wait();
    }
    Process resume(ResumeCommand());
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
      ASSERT_TRUE(process.WaitFor("\"stage\":\"scan\""));
      std::this_thread::sleep_for(milliseconds(1200));
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
  ASSERT_TRUE(process.WaitFor("\"stage\":\"scan\""));
  std::this_thread::sleep_for(milliseconds(1500));
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
  ASSERT_TRUE(process.WaitFor("\"stage\":\"scan\""));
  Process other(ResumeCommand());
  EXPECT_EQ(other.Wait(), 1) << other.text();
  EXPECT_NE(other.text().find("another program"), std::string::npos) << other.text();
  EXPECT_EQ(process.Wait(), 0) << process.text();
}

// It ends with what is there and says how to go on; and with room again it does.
void ExpectStopsAndGoesOn(Process* full, Process* resume) {
  EXPECT_EQ(full->Wait(), 4) << full->text();
  EXPECT_NE(full->text().find("disk full"), std::string::npos) << full->text();
  EXPECT_NE(full->text().find("--resume"), std::string::npos) << full->text();
  EXPECT_EQ(resume->Wait(), 0) << resume->text();
}

TEST_F(ScanProcess, AFullDiskStopsItAndKeepsWhatIsThere) {
  // A limit on the size of files fails writes as a full disk does.
  Process full(ScanCommand({"--realtime"}), [] {
    const rlimit limit{12'000, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  full.Wait();
  const JournalContents contents = ReadJournal(scan_ / "journal.lmv");
  EXPECT_EQ(contents.tail, JournalReader::Tail::kClean);
  EXPECT_GT(contents.replay.frames().size(), 5U);
  EXPECT_LT(contents.replay.frames().size(), static_cast<std::size_t>(kFrames));
  Process resume(ResumeCommand());
  ExpectStopsAndGoesOn(&full, &resume);
}

TEST_F(ScanProcess, AFullTmpfsStopsItAndKeepsWhatIsThere) {
  const fs::path disk = folder_ / "disk";
  fs::create_directories(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=32k") != 0) {
    GTEST_SKIP() << "file systems may not be mounted here; the test with a limit stands for it";
  }
  scan_ = disk / "scan";
  {
    Process full(ScanCommand({"--realtime"}));
    full.Wait();
    EXPECT_GT(ReadJournal(scan_ / "journal.lmv").replay.frames().size(), 5U);
    EXPECT_EQ(mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT, "size=32m"), 0);
    Process resume(ResumeCommand());
    ExpectStopsAndGoesOn(&full, &resume);
  }
  umount(disk.c_str());
}

// A rendered board with things on it, as a folder with video, board.json and intrinsics.
fs::path BoardRecording(const fs::path& folder) {
  Process synth({LIVEMVS_PROGRAM,
                 "synth",
                 "--scene",
                 "board",
                 "--frames",
                 "60",
                 "--arc",
                 "30",
                 "--size",
                 "640x480",
                 "--spp",
                 "1",
                 "--progress",
                 "none",
                 "-o",
                 folder.string()});
  EXPECT_EQ(synth.Wait(), 0) << synth.text();
  return folder;
}

void Append(const Picture& picture, std::string* y4m) {
  *y4m += "FRAME\n";
  for (const auto* plane : {&picture.grey, &picture.cb, &picture.cr}) {
    for (int y = 0; y < plane->height(); ++y) {
      y4m->append(reinterpret_cast<const char*>(plane->Row(y)),
                  static_cast<std::size_t>(plane->width()));
    }
  }
}

// Writes to a FIFO as a camera's program does, and goes away. False where nobody reads it.
bool Send(const fs::path& fifo, const std::vector<std::string>& parts) {
  int fd = -1;
  for (int i = 0; i < 1000 && fd < 0; ++i) {
    fd = ::open(fifo.c_str(), O_WRONLY | O_NONBLOCK);
    if (fd < 0) std::this_thread::sleep_for(milliseconds(10));
  }
  if (fd < 0) return false;
  ::fcntl(fd, F_SETFL, 0);  // from here on it waits
  bool sent = true;
  for (const std::string& part : parts) {
    std::size_t done = 0;
    while (sent && done < part.size()) {
      const ssize_t n = ::write(fd, part.data() + done, part.size() - done);
      sent = n > 0;
      done += sent ? static_cast<std::size_t>(n) : 0;
    }
    std::this_thread::sleep_for(milliseconds(30));
  }
  ::close(fd);
  return sent;
}

TEST_F(ScanProcess, ACameraThatGoesAwayInTheMiddleAndComesBack) {
  std::signal(SIGPIPE, SIG_IGN);
  const fs::path recording = BoardRecording(folder_ / "board");
  const auto video = OpenVideo(recording / "video.mp4");
  std::vector<std::string> first = {"YUV4MPEG2 W640 H480 F30:1 Ip C420\n"}, second = first;
  while (const auto frame = video->Next()) {
    std::string bytes;
    Append(*frame->picture, &bytes);
    (frame->index < 30 ? first : second).push_back(std::move(bytes));
  }
  ASSERT_EQ(second.size(), 31U);
  first.push_back(second[1].substr(0, 1000));  // dies within a picture
  const fs::path fifo = folder_ / "camera";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  Process scan({LIVEMVS_PROGRAM,
                "scan",
                "--data",
                fifo.string(),
                "--board",
                (recording / "board.json").string(),
                "--calibration",
                (recording / "intrinsics.txt").string(),
                "-o",
                scan_.string(),
                "--seeds",
                "5000",
                "--patience",
                "6",
                "--progress",
                "json"});
  ASSERT_TRUE(Send(fifo, first)) << scan.text();
  EXPECT_TRUE(scan.WaitFor("camera lost")) << scan.text();
  ASSERT_TRUE(Send(fifo, second)) << scan.text();
  EXPECT_EQ(scan.Wait(), 0) << scan.text();
  EXPECT_NE(scan.text().find("pictures come again"), std::string::npos) << scan.text();
  EXPECT_NE(scan.text().find("did not come back"), std::string::npos) << scan.text();
  std::ifstream in(scan_ / "statistics.json");
  const nlohmann::json frames = nlohmann::json::parse(in).at("frames");
  EXPECT_EQ(frames.at("tracked").get<int>() + frames.at("untracked").get<int>() +
                frames.at("dropped").get<int>(),
            60)
      << frames;
  EXPECT_EQ(frames.at("untracked"), 0) << frames;
  EXPECT_GT(ReadPly(scan_ / "cloud.ply").cloud.size(), 100U);
  // The scan was recorded on both sides of the gap.
  const Replay replay = ReadJournal(scan_ / "journal.lmv").replay;
  ASSERT_FALSE(replay.frames().empty());
  EXPECT_EQ(replay.frames().front().index, 0);
  EXPECT_EQ(replay.frames().back().index, 59);
}

TEST_F(ScanProcess, PicturesWithoutTheBoardEndWithAClearMessage) {
  BoardRecording(folder_ / "board");
  Process scan({LIVEMVS_PROGRAM,
                "scan",
                "--data",
                Recording().string(),
                "--board",
                (folder_ / "board" / "board.json").string(),
                "-o",
                scan_.string()});
  EXPECT_EQ(scan.Wait(), 3) << scan.text();
  EXPECT_NE(scan.text().find("not seen"), std::string::npos) << scan.text();
  EXPECT_FALSE(fs::exists(scan_ / "cloud.ply"));
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
