#include "livemvs/scan/scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "livemvs/scan/journal_thread.h"
#include "livemvs/stream/journal.h"
#include "scan_test_scene.h"

namespace livemvs {
namespace {

using testing_support::Indices;
using testing_support::kFrameTime;
using testing_support::MemorySink;
using testing_support::PlaneFrames;
using testing_support::PlaneSettings;
using testing_support::PointsOf;
using testing_support::SamePositions;
using testing_support::ScriptedSource;
using testing_support::TruePoses;
namespace fs = std::filesystem;

TEST(Scan, GivesTheCloudOfTheReconstructorAndTheStreamSaysTheSame) {
  ScriptedSource source;
  source.AddFrames(0, 30);
  TruePoses poses;
  Scan scan(PlaneSettings(), &source, &poses);
  MemorySink sink;
  scan.AddSink(&sink);
  int told = 0;
  const ScanResult result = scan.Run({.progress = [&](const ScanProgress&) { ++told; }});
  EXPECT_EQ(result.end, ScanEnd::kFinished);
  EXPECT_EQ(result.failure, nullptr);
  EXPECT_GE(told, 30);
  ASSERT_GT(result.points.size(), 500U);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(0, 30))));
  EXPECT_EQ(result.capture.tracked, 30);
  EXPECT_EQ(result.frames.size(), 30U);

  const Replay& replay = sink.replay;
  EXPECT_EQ(replay.malformed(), 0);
  ASSERT_EQ(replay.frames().size(), 30U);
  EXPECT_EQ(replay.frames()[29].index, 29);
  EXPECT_NEAR(replay.frames()[29].timestamp, 29 * kFrameTime, 1e-12);
  EXPECT_EQ(replay.camera()->fx, PlaneFrames()[0].camera.fx);
  EXPECT_EQ(replay.scene()->near, 0.6);
  ASSERT_TRUE(replay.end());
  EXPECT_EQ(replay.end()->points, static_cast<std::int64_t>(result.points.size()));
  const PointCloud streamed = replay.Points();
  ASSERT_EQ(streamed.size(), result.points.size());
  // The stream's order is its own, within a frame.
  double sum = 0, streamed_sum = 0;
  for (const Point& p : result.points) sum += PlaneFrames()[0].camera.fx * p.position.x();
  for (const Point& p : streamed) streamed_sum += PlaneFrames()[0].camera.fx * p.position.x();
  EXPECT_NEAR(sum / static_cast<double>(streamed.size()),
              streamed_sum / static_cast<double>(streamed.size()),
              1e-3);
}

TEST(Scan, AStopEndsItWithWhatIsThere) {
  ScriptedSource source;
  source.AddFrames(0, 30);
  TruePoses poses;
  Scan scan(PlaneSettings(), &source, &poses);
  MemorySink sink;
  scan.AddSink(&sink);
  std::int64_t frames = 0;
  const ScanResult result =
      scan.Run({.stop = [&] { return frames >= 20; },
                .progress = [&](const ScanProgress& p) { frames = p.frames; }});
  EXPECT_EQ(result.end, ScanEnd::kInterrupted);
  EXPECT_TRUE(SamePositions(result.points, PointsOf(Indices(0, 20))));
  EXPECT_EQ(sink.replay.end()->reason, EndMessage::kInterrupted);
}

TEST(Scan, GoesOnWhereAnotherStopped) {
  ScriptedSource first_source;
  first_source.AddFrames(0, 30);
  TruePoses poses;
  MemorySink sink;
  {
    Scan scan(PlaneSettings(), &first_source, &poses);
    scan.AddSink(&sink);
    scan.Run({});
  }
  const std::size_t before = sink.replay.Points().size();
  ASSERT_GT(before, 500U);
  ScriptedSource second_source;
  second_source.AddFrames(10, 60);  // the seeds that were alive are grown again
  Scan scan(PlaneSettings(), &second_source, &poses);
  scan.Continue(Replay(sink.replay));
  scan.AddSink(&sink);
  const ScanResult result = scan.Run({});
  EXPECT_EQ(sink.replay.malformed(), 0);
  ASSERT_EQ(result.frames.size(), 60U);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_EQ(result.frames[i].index, static_cast<std::int64_t>(i)) << "recorded once";
  }
  EXPECT_EQ(sink.replay.frames().size(), 60U);
  EXPECT_EQ(sink.replay.Points().size(), result.points.size());
  // As many points as without the break.
  const auto whole = static_cast<double>(PointsOf(Indices(0, 60)).size());
  EXPECT_NEAR(static_cast<double>(result.points.size()), whole, 0.1 * whole);
  for (const Point& p : result.points) {
    EXPECT_LT(std::abs(testing_support::PlaneScene::HeightAbove(p.position.cast<double>())), 0.1);
  }
}

TEST(Scan, TheJournalOnDiskIsTheStream) {
  const fs::path path = fs::path(::testing::TempDir()) / "scan_test_journal.lmv";
  fs::remove(path);
  ScriptedSource source;
  source.AddFrames(0, 20);
  TruePoses poses;
  Scan scan(PlaneSettings(), &source, &poses);
  MemorySink memory;
  JournalThread journal(std::make_unique<JournalWriter>(path));
  for (RecordSink* sink : std::initializer_list<RecordSink*>{&memory, &journal}) {
    scan.AddSink(sink);
    sink->Write(RecordType::kSession, Encode(SessionMessage{}));
  }
  scan.Run({});
  journal.Finish();
  const JournalContents contents = ReadJournal(path);
  EXPECT_EQ(contents.tail, JournalReader::Tail::kClean);
  EXPECT_EQ(contents.next_sequence, memory.count);
  EXPECT_TRUE(SamePositions(contents.replay.Points(), memory.replay.Points()));
  fs::remove(path);
}

}  // namespace
}  // namespace livemvs
