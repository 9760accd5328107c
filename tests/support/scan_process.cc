#include "scan_process.h"

#include <chrono>
#include <thread>

#include "livemvs/io/ply.h"
#include "livemvs/io/tum.h"
#include "livemvs/stream/replay.h"
#include "livemvs/synth/export.h"

namespace livemvs {

namespace fs = std::filesystem;

fs::path ScanProcess::Recording() {
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

void ScanProcess::SetUp() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  folder_ = fs::path(::testing::TempDir()) / (std::string("scan_process_") + info->name());
  fs::remove_all(folder_);
  fs::create_directories(folder_);
  scan_ = folder_ / "scan";
}

void ScanProcess::TearDown() { fs::remove_all(folder_); }

std::vector<std::string> ScanProcess::ScanCommand(const std::vector<std::string>& more) const {
  std::vector<std::string> command = {LIVEMVS_PROGRAM,
                                      "scan",
                                      "--data",
                                      Recording().string(),
                                      "-o",
                                      scan_.string(),
                                      "--seeds",
                                      "3500",
                                      "--threads",
                                      "2",
                                      "--progress",
                                      "json"};
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

std::vector<std::string> ScanProcess::ResumeCommand() const {
  return {LIVEMVS_PROGRAM, "scan", "--resume", scan_.string(), "--threads", "2"};
}

bool ScanProcess::WaitForJournal(std::size_t frames, std::size_t points) const {
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < std::chrono::minutes(1)) {
    std::error_code error;
    const auto size = fs::file_size(scan_ / "journal.lmv", error);
    if (!error && size > 0) {
      if (frames == 0 && points == 0) return true;
      const Replay replay = ReadJournal(scan_ / "journal.lmv").replay;
      if (replay.frames().size() >= frames && replay.Points().size() >= points) return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

void ScanProcess::ExpectWhole() const {
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

}  // namespace livemvs
