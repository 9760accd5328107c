// 'livemvs scan' as a program whose disk is full, whose camera goes away, or that does not see the
// board.

#include <sys/mount.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fifo.h"
#include "livemvs/io/ply.h"
#include "livemvs/io/video_source.h"
#include "livemvs/stream/replay.h"
#include "scan_process.h"

namespace livemvs {
namespace {

using testing_support::Fifo;
using testing_support::Process;
namespace fs = std::filesystem;

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

TEST_F(ScanProcess, ACameraThatGoesAwayInTheMiddleAndComesBack) {
  const fs::path recording = BoardRecording(folder_ / "board");
  const auto video = OpenVideo(recording / "video.mp4");
  std::vector<std::string> first = {testing_support::Y4mHeader(640, 480)}, second = first;
  while (const auto frame = video->Next()) {
    (frame->index < 30 ? first : second).push_back(testing_support::Y4mFrame(*frame->picture));
  }
  ASSERT_EQ(second.size(), 31U);
  first.push_back(second[1].substr(0, 1000));  // dies within a picture
  const fs::path pipe = folder_ / "camera";
  Fifo fifo(pipe);
  Process scan({LIVEMVS_PROGRAM,
                "scan",
                "--data",
                pipe.string(),
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
  ASSERT_TRUE(fifo.Send(first)) << scan.text();
  EXPECT_TRUE(scan.WaitFor("camera lost")) << scan.text();
  ASSERT_TRUE(fifo.Send(second)) << scan.text();
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
  EXPECT_LT(replay.frames().front().index, 30);  // 0, where nothing was late
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

}  // namespace
}  // namespace livemvs
