// What a scan must survive: cameras that go away, clocks that jump, poses that are none, and a full
// disk.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <thread>

#include "livemvs/core/error.h"
#include "livemvs/scan/journal_thread.h"
#include "livemvs/scan/scan.h"
#include "scan_test_scene.h"

namespace livemvs {
namespace {

using std::chrono::milliseconds;
using testing_support::Indices;
using testing_support::MemorySink;
using testing_support::PlaneFrames;
using testing_support::PlaneSettings;
using testing_support::PointsOf;
using testing_support::SamePositions;
using testing_support::ScriptedSource;
using testing_support::SourceFrameOf;
using testing_support::TruePoses;
namespace fs = std::filesystem;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ScanResult RunScan(ScriptedSource* source, PoseSource* poses, MemorySink* sink = nullptr) {
  Scan scan(PlaneSettings(), source, poses);
  if (sink != nullptr) scan.AddSink(sink);
  return scan.Run({});
}

TEST(ScanFaults, PicturesOutOfOrderOrTwiceChangeNothing) {
  ScriptedSource source;
  for (std::size_t i = 0; i < 30; ++i) {
    const SourceFrame frame = SourceFrameOf(PlaneFrames()[i]);
    source.Add(frame);
    if (i % 5 == 4) source.Add(frame);                                // twice
    if (i % 7 == 6) source.Add(SourceFrameOf(PlaneFrames()[i - 3]));  // from before
    if (i % 9 == 8) {
      SourceFrame repeated = frame;  // with a new time
      repeated.timestamp += 0.01;
      source.Add(repeated);
    }
  }
  TruePoses poses;
  const ScanResult result = RunScan(&source, &poses);
  EXPECT_EQ(result.capture.out_of_order, 6 + 4);
  EXPECT_EQ(result.capture.duplicates, 3);
  EXPECT_EQ(result.capture.tracked, 30);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(0, 30))));
}

// Frames with such poses must leave the seeds as if they had not been filmed.
void ExpectBadPosesAreLeftOut(const std::function<void(PoseEstimate*)>& spoil) {
  ScriptedSource source;
  source.AddFrames(0, 30);
  TruePoses poses;
  std::vector<std::size_t> good;
  for (std::size_t i = 0; i < 30; ++i) {
    if (i % 4 != 2) good.push_back(i);
  }
  poses.spoil = [&](std::size_t i, PoseEstimate* pose) {
    if (i % 4 == 2) spoil(pose);
  };
  MemorySink sink;
  const ScanResult result = RunScan(&source, &poses, &sink);
  EXPECT_EQ(result.end, ScanEnd::kFinished);
  EXPECT_EQ(result.capture.bad_poses, 7);
  EXPECT_EQ(result.capture.untracked, 7);
  EXPECT_EQ(result.capture.tracked, 23);
  ASSERT_EQ(result.frames.size(), 30U);
  EXPECT_FALSE(result.frames[2].cam_from_world);
  EXPECT_EQ(result.frames[2].tracking_state, 2);
  EXPECT_EQ(sink.replay.malformed(), 0);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(good)));
}

TEST(ScanFaults, PosesThatAreNotNumbersNeverTouchSeeds) {
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) { p->cam_from_world->translation.y() = kNaN; });
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) { p->cam_from_world->rotation(1, 2) = kNaN; });
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) {
    p->cam_from_world->translation.x() = std::numeric_limits<double>::infinity();
    p->rms_px = kNaN;
    p->blur_px = kNaN;
  });
}

TEST(ScanFaults, PosesThatAreNoRigidMotionNeverTouchSeeds) {
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) { p->cam_from_world->rotation.setZero(); });
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) { p->cam_from_world->rotation *= 1.01; });
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) { p->cam_from_world->rotation *= -1; });
  ExpectBadPosesAreLeftOut([](PoseEstimate* p) { p->cam_from_world->translation *= 1e27; });
}

TEST(ScanFaults, ATrackerThatThrowsLosesItsFrameAlone) {
  ExpectBadPosesAreLeftOut(
      [](PoseEstimate* /*pose*/) { throw std::runtime_error("the solver gave up"); });
}

TEST(ScanFaults, FramesWithoutAPoseNeverTouchSeeds) {
  ScriptedSource source;
  source.AddFrames(0, 30);
  TruePoses poses;
  poses.spoil = [](std::size_t i, PoseEstimate* pose) {
    if (i < 10) *pose = PoseEstimate{.problem = "board not seen"};
  };
  const ScanResult result = RunScan(&source, &poses);
  EXPECT_EQ(result.capture.bad_poses, 0);
  EXPECT_EQ(result.capture.untracked, 10);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(10, 30))));
}

TEST(ScanFaults, ACameraThatGoesAwayAndComesBackIsToldOf) {
  ScriptedSource source;
  source.AddFrames(0, 15);
  source.steps.push_back([] {
    LiveSource::Answer answer;
    answer.status = LiveSource::Status::kLost;
    answer.problem = "unplugged";
    return answer;
  });
  for (int i = 0; i < 10; ++i) {
    source.steps.push_back([] {
      std::this_thread::sleep_for(milliseconds(20));
      return LiveSource::Answer{};
    });
  }
  source.AddFrames(15, 30);
  TruePoses poses;
  Scan scan(PlaneSettings(), &source, &poses);
  MemorySink sink;
  scan.AddSink(&sink);
  std::vector<std::string> news;
  const ScanResult result =
      scan.Run({.news = [&](const std::string& text, bool) { news.push_back(text); }});
  EXPECT_EQ(result.end, ScanEnd::kFinished);
  EXPECT_EQ(news, (std::vector<std::string>{"camera lost: unplugged", "pictures come again"}));
  EXPECT_EQ(std::count(sink.types.begin(), sink.types.end(), RecordType::kMessage), 2);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(0, 30))));
}

TEST(ScanFaults, ACameraThatStaysAwayEndsTheScanAfterAWhile) {
  ScriptedSource source;
  source.AddFrames(0, 20);
  for (int i = 0; i < 1000; ++i) {
    source.steps.push_back([] {
      std::this_thread::sleep_for(milliseconds(10));
      return LiveSource::Answer{};
    });
  }
  TruePoses poses;
  ScanSettings settings = PlaneSettings();
  settings.stages.capture.lost_after = 0.2;
  settings.stages.patience = 0.5;
  Scan scan(settings, &source, &poses);
  const auto start = std::chrono::steady_clock::now();
  const ScanResult result = scan.Run({});
  EXPECT_LT(std::chrono::steady_clock::now() - start, milliseconds(5000));
  EXPECT_EQ(result.end, ScanEnd::kSourceLost);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(0, 20))));
}

TEST(ScanFaults, ASourceThatBreaksKeepsThePointsSoFar) {
  ScriptedSource source;
  source.AddFrames(0, 20);
  source.steps.push_back([]() -> LiveSource::Answer { throw BadInput("the wire broke"); });
  TruePoses poses;
  MemorySink sink;
  const ScanResult result = RunScan(&source, &poses, &sink);
  EXPECT_EQ(result.end, ScanEnd::kFailed);
  EXPECT_THROW(std::rethrow_exception(result.failure), Error);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(0, 20))));
  EXPECT_EQ(sink.replay.end()->reason, EndMessage::kFailed);
  EXPECT_EQ(sink.replay.end()->text, "the wire broke");
}

TEST(ScanFaults, AFullDiskStopsTheScanAndKeepsWhatIsThere) {
  const fs::path path = fs::path(::testing::TempDir()) / "scan_fault_journal.lmv";
  fs::remove(path);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const rlimit limit{20'000, old_limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);

  ScriptedSource source;
  for (std::size_t i = 0; i < 60; ++i) {
    source.AddFrames(i, i + 1);
    source.steps.push_back([] {
      std::this_thread::sleep_for(milliseconds(40));
      return LiveSource::Answer{};
    });
  }
  TruePoses poses;
  Scan scan(PlaneSettings(), &source, &poses);
  JournalThread journal(std::make_unique<JournalWriter>(path));
  journal.Write(RecordType::kSession, Encode(SessionMessage{}));
  scan.AddSink(&journal);
  const ScanResult result = scan.Run({.broken = [&]() -> std::exception_ptr {
    if (!journal.failed()) return nullptr;
    return std::make_exception_ptr(Error(ErrorKind::kOutOfResource, "disk full"));
  }});
  EXPECT_THROW(journal.Finish(), Error);
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);

  EXPECT_EQ(result.end, ScanEnd::kFailed);
  EXPECT_LT(result.frames.size(), 60U) << "it stopped";
  EXPECT_GT(result.points.size(), 100U) << "in memory everything is there";
  const JournalContents contents = ReadJournal(path);
  EXPECT_EQ(contents.tail, JournalReader::Tail::kClean);
  EXPECT_GT(contents.replay.frames().size(), 5U);
  EXPECT_EQ(contents.replay.malformed(), 0);
  fs::remove(path);
}

TEST(ScanFaults, PicturesOfAnotherSizeThanTheCalibrationAreNotUsed) {
  class OtherCamera final : public TruePoses {
    Camera camera() const override {
      Camera camera = TruePoses::camera();
      camera.width += 2;
      return camera;
    }
  };
  ScriptedSource source;
  source.AddFrames(0, 5);
  OtherCamera poses;
  const ScanResult result = RunScan(&source, &poses);
  EXPECT_EQ(result.end, ScanEnd::kFinished);
  EXPECT_EQ(result.reconstruction.frames, 0);
}

TEST(IsRigid, TellsRotationsFromOthers) {
  Rigid3d pose;
  EXPECT_TRUE(IsRigid(pose));
  pose.rotation(0, 0) = -1;  // a reflection
  EXPECT_FALSE(IsRigid(pose));
}

}  // namespace
}  // namespace livemvs
