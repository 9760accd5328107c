#include "viewer/feed.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "livemvs/io/picture_codec.h"
#include "livemvs/stream/bytes.h"
#include "livemvs/stream/messages.h"
#include "livemvs/stream/replay.h"
#include "viewer/mesh_record.h"

namespace livemvs::viewer {
namespace {

constexpr int kWidth = 320, kHeight = 240;

PosedFrame MakeFrame(std::int64_t index) {
  auto picture = std::make_shared<Picture>();
  picture->grey = Image<std::uint8_t>(kWidth, kHeight);
  picture->full_range = true;
  std::mt19937 random(7);
  for (int y = 0; y < kHeight; ++y) {
    // The right half is plain.
    for (int x = 0; x < kWidth; ++x) {
      picture->grey(x, y) = static_cast<std::uint8_t>(x < kWidth / 2 ? random() & 255U : 90);
    }
  }
  PosedFrame frame;
  frame.index = index;
  frame.timestamp = 0.04 * static_cast<double>(index);
  frame.picture = picture;
  frame.camera.width = kWidth;
  frame.camera.height = kHeight;
  frame.camera.fx = frame.camera.fy = 300;
  frame.camera.cx = kWidth / 2.0;
  frame.camera.cy = kHeight / 2.0;
  frame.cam_from_world.translation.x() = -0.01 * static_cast<double>(index);
  return frame;
}

// A plane at z = 2, sampled anew.
PointCloud Film(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-0.4F, 0.4F);
  PointCloud cloud(20000);
  for (Point& point : cloud) {
    point.position = {place(random), place(random), 2};
    point.normal = {0, 0, -1};
    point.color = {10, 200, 30};
    point.sigma = 0.001F;
    point.inlier_ratio = 0.7F;
    point.views = 9;
    point.footprint = 2.0F / 300;
  }
  return cloud;
}

// The state that a log's records add up to.
Replay ReplayOf(const StreamLog& log) {
  Replay replay;
  StreamLog::Cursor cursor;
  while (cursor.next < log.size()) {
    for (const SharedBytes& bytes : log.Take(&cursor, 1 << 20)) {
      const ParseResult result = ParseRecord(*bytes);
      EXPECT_EQ(result.status, ParseStatus::kRecord);
      if (result.record.sequence != kUnnumbered) replay.Apply(result.record);
    }
  }
  return replay;
}

TEST(Feed, StreamsEachPieceOfSurfaceOnce) {
  StreamLog log;
  std::size_t once = 0, twice = 0;
  {
    Feed feed(&log, {});
    feed.Begin({.json = "{}"}, SceneMessage{std::nullopt, 1, 3, "a test"});
    for (unsigned i = 0; i < 6; ++i) {
      feed.AddFrame(MakeFrame(i), Film(i), {.frames = i + 1}, nullptr);
    }
    feed.End({.frames = 6});
    once = feed.map_points();
  }
  const Replay replay = ReplayOf(log);
  EXPECT_EQ(replay.malformed(), 0);
  EXPECT_EQ(replay.frames().size(), 6U);
  ASSERT_TRUE(replay.camera().has_value());
  EXPECT_EQ(replay.camera()->fx, 300);
  ASSERT_TRUE(replay.end().has_value());
  ASSERT_TRUE(replay.scene().has_value());
  const PointCloud points = replay.Points();
  twice = points.size();
  EXPECT_EQ(once, twice);  // the stream adds up to what the map holds
  EXPECT_GT(points.size(), 1000U);
  EXPECT_LT(points.size(), 20000U);  // of 120 000
  std::size_t refined = 0;
  for (const Point& point : points) {
    EXPECT_NEAR(point.position.z(), 2, 1e-3);
    EXPECT_EQ(point.color, (Rgb{10, 200, 30}));
    refined += point.sigma < 0.0009F ? 1 : 0;
  }
  EXPECT_GT(refined, points.size() / 2);
}

TEST(Feed, SendsAPictureWithMarks) {
  StreamLog log;
  FeedOptions options;
  options.preview_width = 160;
  Feed feed(&log, options);
  feed.Begin({.json = "{}"}, std::nullopt);
  feed.AddFrame(MakeFrame(3), Film(1), {.frames = 1}, nullptr);
  feed.End({});
  StreamLog::Cursor cursor;
  std::vector<std::uint8_t> preview;
  for (int round = 0; round < 10; ++round) {
    for (const SharedBytes& bytes : log.Take(&cursor, 1 << 20)) {
      const Record record = ParseRecord(*bytes).record;
      if (record.type == kRecordPreview)
        preview.assign(record.payload.begin(), record.payload.end());
    }
  }
  ASSERT_GT(preview.size(), 24U);
  ByteReader in(preview);
  EXPECT_EQ(in.Get<std::int64_t>(), 3);
  EXPECT_GT(in.Get<double>(), 1.6e9);
  const auto marks = in.Get<std::uint32_t>();
  const auto bytes = in.Get<std::uint32_t>();
  ASSERT_EQ(preview.size(), 24 + 8 * marks + bytes);
  std::size_t plain_left = 0, plain_right = 0, converged = 0;
  for (std::uint32_t i = 0; i < marks; ++i) {
    const auto x = in.Get<std::uint16_t>();
    in.Get<std::uint16_t>();
    const auto kind = static_cast<MarkKind>(in.Get<std::uint8_t>());
    in.Get<std::uint8_t>();
    in.Get<std::uint16_t>();
    if (kind == MarkKind::kNoTexture) ++(x < 32768 ? plain_left : plain_right);
    if (kind == MarkKind::kConverged) ++converged;
  }
  EXPECT_EQ(plain_left, 0U);
  EXPECT_GT(plain_right, 100U);
  EXPECT_GT(converged, 100U);
  const std::string path = testing::TempDir() + "/feed_test.jpg";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(preview.data()) + preview.size() - bytes, bytes);
  const Picture picture = ReadPicture(path);
  EXPECT_EQ(picture.width(), 160);
  EXPECT_EQ(picture.height(), 120);
  EXPECT_NEAR(picture.grey(140, 60), 90, 6);
}

// The engine must not wait: thousands of frames are handed over in less time than the feed takes.
TEST(Feed, TakesFramesWithoutWaiting) {
  StreamLog log;
  Feed feed(&log, {});
  feed.Begin({.json = "{}"}, std::nullopt);
  const PosedFrame frame = MakeFrame(0);
  const PointCloud points = Film(1);
  const auto start = std::chrono::steady_clock::now();
  constexpr int kFrames = 200;
  for (int i = 0; i < kFrames; ++i) feed.AddFrame(frame, points, {.frames = i}, nullptr);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LT(seconds, 30.0);  // copies of 1.1 MB each: far more than they take on a busy machine
  feed.End({.frames = kFrames});
  EXPECT_EQ(ReplayOf(log).frames().size(), static_cast<std::size_t>(kFrames));
}

// What a client that never looks away gets of the records that are not kept, of one type.
std::vector<std::vector<std::uint8_t>> TakeUnnumbered(StreamLog* log,
                                                      StreamLog::Cursor* cursor,
                                                      RecordType type) {
  std::vector<std::vector<std::uint8_t>> payloads;
  for (std::vector<SharedBytes> taken = log->Take(cursor, 1 << 20); !taken.empty();
       taken = log->Take(cursor, 1 << 20)) {
    for (const SharedBytes& bytes : taken) {
      const Record record = ParseRecord(*bytes).record;
      if (record.type == type) payloads.emplace_back(record.payload.begin(), record.payload.end());
    }
  }
  return payloads;
}

// While the camera's place is not known its picture is shown all the same, with what says nothing
// of depth: plain blocks. Nothing of it is kept: the stream holds no frame and no point.
TEST(Feed, ShowsThePictureOfAFrameWithoutAPose) {
  StreamLog log;
  Feed feed(&log, {});
  feed.Begin({.json = "{}"}, std::nullopt);
  const std::size_t before = log.size();
  feed.AddPicture(17, MakeFrame(17).picture);
  feed.End({});
  EXPECT_EQ(log.size(), before + 1);  // the end alone
  StreamLog::Cursor cursor;
  const auto previews = TakeUnnumbered(&log, &cursor, kRecordPreview);
  ASSERT_EQ(previews.size(), 1U);
  ByteReader in(previews[0]);
  EXPECT_EQ(in.Get<std::int64_t>(), 17);
  EXPECT_GT(in.Get<double>(), 1.6e9);
  const auto marks = in.Get<std::uint32_t>();
  const auto bytes = in.Get<std::uint32_t>();
  ASSERT_EQ(previews[0].size(), 24 + 8 * marks + bytes);
  EXPECT_GT(marks, 100U);
  EXPECT_GT(bytes, 1000U);
  for (std::uint32_t i = 0; i < marks; ++i) {
    in.Get<std::uint32_t>();
    EXPECT_EQ(static_cast<MarkKind>(in.Get<std::uint8_t>()), MarkKind::kNoTexture);
    in.Get<std::uint8_t>();
    in.Get<std::uint16_t>();
  }
}

// Pictures come at the camera's rate, and are shown at that of the previews; those of frames with
// and without a pose share it.
TEST(Feed, ShowsNoMorePicturesThanAreAskedFor) {
  StreamLog log;
  FeedOptions options;
  options.preview_hz = 0.02;
  Feed feed(&log, options);
  feed.Begin({.json = "{}"}, std::nullopt);
  feed.AddPicture(1, MakeFrame(1).picture);
  for (int i = 2; i < 100; ++i) feed.AddPicture(i, nullptr);  // not even looked at
  feed.AddFrame(MakeFrame(100), {}, {.frames = 1}, nullptr);
  feed.End({});
  StreamLog::Cursor cursor;
  const auto previews = TakeUnnumbered(&log, &cursor, kRecordPreview);
  ASSERT_EQ(previews.size(), 1U);
  EXPECT_EQ(ByteReader(previews[0]).Get<std::int64_t>(), 1);
  EXPECT_EQ(ReplayOf(log).frames().size(), 1U);
}

nlohmann::json LiveOf(StreamLog* log) {
  StreamLog::Cursor cursor;
  const auto lives = TakeUnnumbered(log, &cursor, kRecordLive);
  EXPECT_FALSE(lives.empty());
  if (lives.empty()) return {};
  return nlohmann::json::parse(DecodeStatistics(lives.back()).value_or("{}"));
}

TEST(Feed, TellsCountsWithoutAFrame) {
  StreamLog log;
  FeedOptions options;
  options.records = false;  // as for a scan, whose journal is the stream
  Feed feed(&log, options);
  feed.SetCounts({.frames = 5, .frames_total = 40, .seeds = 1});
  feed.SetCounts({.frames = 7,
                  .frames_total = 40,
                  .frames_dropped = 2,
                  .seeds = 300,
                  .points = 1234,
                  .problem = "board not seen"});
  feed.End({});
  EXPECT_EQ(log.size(), 0U);
  const nlohmann::json live = LiveOf(&log);
  EXPECT_EQ(live.at("frames"), 7);
  EXPECT_EQ(live.at("frames_total"), 40);
  EXPECT_EQ(live.at("frames_dropped"), 2);
  EXPECT_EQ(live.at("seeds"), 300);
  EXPECT_EQ(live.at("points"), 1234);
  EXPECT_EQ(live.at("problem"), "board not seen");
  EXPECT_TRUE(live.at("handed").empty());
}

// The problem goes when the next counts have none, and may be any bytes.
TEST(Feed, ForgetsAProblemThatIsOver) {
  StreamLog log;
  Feed feed(&log, {});
  feed.SetCounts({.problem = "board \xff not seen"});
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  nlohmann::json live;
  while (!live.contains("problem") && std::chrono::steady_clock::now() < deadline) {
    StreamLog::Cursor cursor;
    const auto lives = TakeUnnumbered(&log, &cursor, kRecordLive);
    if (!lives.empty()) live = nlohmann::json::parse(DecodeStatistics(lives.back()).value_or("{}"));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(live.contains("problem"));
  EXPECT_NE(live.at("problem").get<std::string>().find("not seen"), std::string::npos);
  feed.SetCounts({.frames = 1});
  feed.End({});
  EXPECT_FALSE(LiveOf(&log).contains("problem"));
}

TEST(MeshRecord, SplitsMeshesAndLeavesOutWildFaces) {
  PlyContents mesh;
  mesh.has_colors = true;
  for (int i = 0; i < 4; ++i) {
    Point point;
    point.position = {static_cast<float>(i), 0, 1};
    mesh.cloud.push_back(point);
  }
  mesh.faces = {{0, 1, 2}, {1, 2, 99}, {-1, 0, 1}, {1, 2, 3}};
  const auto parts = EncodeMesh(mesh);
  ASSERT_EQ(parts.size(), 1U);
  ByteReader in(parts[0]);
  EXPECT_EQ(in.Get<std::uint32_t>(), 4U);
  EXPECT_EQ(in.Get<std::uint32_t>(), 2U);
  EXPECT_EQ(in.Get<std::uint32_t>(), 1U);
  EXPECT_EQ(parts[0].size(), 16U + 4 * 16 + 2 * 12);
  for (int i = 0; i < 250'000; ++i) mesh.faces.push_back({0, 1, 2});
  EXPECT_EQ(EncodeMesh(mesh).size(), 3U);
}

}  // namespace
}  // namespace livemvs::viewer
