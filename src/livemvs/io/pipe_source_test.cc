#include "livemvs/io/pipe_source.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>
#include <vector>

#include "livemvs/io/capture_queue.h"
#include "livemvs/io/media_test_util.h"
#include "livemvs/io/video_writer.h"

namespace livemvs {
namespace {

using std::chrono::milliseconds;

constexpr int kPipeWidth = 160, kPipeHeight = 96;
constexpr int kPipeFrames = 20;

class PipeSourceTest : public MediaTest {
 protected:
  void SetUp() override {
    MediaTest::SetUp();
    std::signal(SIGPIPE, SIG_IGN);
    path_ = folder_ / "pipe";
    ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  }
  void TearDown() override {
    if (writer_.joinable()) writer_.join();
    MediaTest::TearDown();
  }

  // Writes the parts to the pipe, with pauses between them, and closes it.
  void WriteLater(std::vector<std::string> parts, milliseconds pause = milliseconds(0)) {
    if (writer_.joinable()) writer_.join();
    writer_ = std::thread([this, parts = std::move(parts), pause] {
      const int fd = ::open(path_.c_str(), O_WRONLY);
      for (const std::string& part : parts) {
        if (!Write(fd, part)) break;
        std::this_thread::sleep_for(pause);
      }
      ::close(fd);
    });
  }

  static bool Write(int fd, const std::string& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  }

  // All pictures until the writer is gone.
  static std::vector<SourceFrame> ReadAll(LiveSource* source) {
    std::vector<SourceFrame> frames;
    while (true) {
      LiveSource::Answer answer = source->Next();
      if (answer.status == LiveSource::Status::kFrame) frames.push_back(std::move(answer.frame));
      if (answer.status == LiveSource::Status::kLost) return frames;
    }
  }

  std::string Y4m(int first, int count) const {
    std::string bytes = "YUV4MPEG2 W160 H96 F25:1 Ip C420\n";
    for (int i = first; i < first + count; ++i) {
      bytes += "FRAME\n";
      AppendPlanes(NumberedPicture(i, kPipeWidth, kPipeHeight), &bytes);
    }
    return bytes;
  }

  static void AppendPlanes(const Picture& picture, std::string* bytes) {
    for (const auto* plane : {&picture.grey, &picture.cb, &picture.cr}) {
      for (int y = 0; y < plane->height(); ++y) {
        bytes->append(reinterpret_cast<const char*>(plane->Row(y)),
                      static_cast<std::size_t>(plane->width()));
      }
    }
  }

  // YUYV as webcams send it.
  static std::string Yuyv(int number) {
    const Picture picture = NumberedPicture(number, kPipeWidth, kPipeHeight);
    std::string bytes;
    for (int y = 0; y < kPipeHeight; ++y) {
      for (int x = 0; x < kPipeWidth; ++x) {
        bytes += static_cast<char>(picture.grey(x, y));
        const auto& chroma = x % 2 == 0 ? picture.cb : picture.cr;
        bytes += static_cast<char>(chroma(x / 2, y / 2));
      }
    }
    return bytes;
  }

  // A JPEG image, taken out of a Motion JPEG video: its packets are whole JPEG files.
  std::string Jpeg(int number) const {
    VideoWriterOptions options;
    options.width = kPipeWidth;
    options.height = kPipeHeight;
    options.encoder = "mjpeg";
    options.full_range = true;
    VideoWriter writer(folder_ / "jpeg.avi", options);
    writer.Write(NumberedPicture(number, kPipeWidth, kPipeHeight));
    writer.Finish();
    const std::string avi = ReadBytes(folder_ / "jpeg.avi");
    const std::size_t begin = avi.find("\xFF\xD8\xFF");
    return avi.substr(begin, avi.rfind("\xFF\xD9") + 2 - begin);
  }

  std::string Video(const std::string& name, const std::string& encoder) const {
    VideoWriterOptions options;
    options.width = kPipeWidth;
    options.height = kPipeHeight;
    options.frames_per_second = 25;
    options.encoder = encoder;
    VideoWriter writer(folder_ / name, options);
    for (int i = 0; i < kPipeFrames; ++i) writer.Write(NumberedPicture(i, kPipeWidth, kPipeHeight));
    writer.Finish();
    return ReadBytes(folder_ / name);
  }

  std::filesystem::path path_;
  std::thread writer_;
};

TEST_F(PipeSourceTest, ReadsY4mToThePixelWithItsTimes) {
  WriteLater({Y4m(0, kPipeFrames)});
  const auto source = OpenPipe(path_, {});
  EXPECT_EQ(source->info().width, kPipeWidth);
  EXPECT_EQ(source->info().height, kPipeHeight);
  const auto frames = ReadAll(source.get());
  ASSERT_EQ(frames.size(), static_cast<std::size_t>(kPipeFrames));
  constexpr double kRounding = 1e-6;
  for (int i = 0; i < kPipeFrames; ++i) {
    EXPECT_EQ(frames[i].index, i);
    EXPECT_NEAR(frames[i].timestamp - frames[0].timestamp, i / 25.0, kRounding);
    EXPECT_EQ(
        MeanDifference(frames[i].picture->grey, NumberedPicture(i, kPipeWidth, kPipeHeight).grey),
        0);
  }
}

TEST_F(PipeSourceTest, ReadsMotionJpegWithTheTimesOfArrival) {
  std::vector<std::string> parts;
  for (int i = 0; i < kPipeFrames; ++i) {
    parts.push_back(Jpeg(i));
  }
  WriteLater(parts, milliseconds(10));
  const auto source = OpenPipe(path_, {});
  const auto frames = ReadAll(source.get());
  // The last ends only where the next one would begin.
  ASSERT_GE(frames.size(), static_cast<std::size_t>(kPipeFrames - 1));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(NumberIn(*frames[i].picture), static_cast<int>(i));
    EXPECT_GT(frames[i].timestamp, i > 0 ? frames[i - 1].timestamp : -1);
  }
}

TEST_F(PipeSourceTest, ReadsH264InMatroska) {
  WriteLater({Video("video.mkv", "libx264")});
  const auto source = OpenPipe(path_, {});
  const auto frames = ReadAll(source.get());
  ASSERT_GE(frames.size(), static_cast<std::size_t>(kPipeFrames - 3))
      << "the decoder may keep a few";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(NumberIn(*frames[i].picture), static_cast<int>(i));
  }
}

TEST_F(PipeSourceTest, ReadsRawFramesOfACamera) {
  std::vector<std::string> parts;
  for (int i = 0; i < kPipeFrames; ++i) parts.push_back(Yuyv(i));
  WriteLater(parts);
  const auto source =
      OpenPipe(path_, {.format = "yuyv422", .width = kPipeWidth, .height = kPipeHeight});
  const auto frames = ReadAll(source.get());
  ASSERT_EQ(frames.size(), static_cast<std::size_t>(kPipeFrames));
  for (int i = 0; i < kPipeFrames; ++i) {
    EXPECT_EQ(
        MeanDifference(frames[i].picture->grey, NumberedPicture(i, kPipeWidth, kPipeHeight).grey),
        0);
    EXPECT_FALSE(frames[i].picture->cb.empty());
  }
}

TEST_F(PipeSourceTest, AWriterThatDiesIsNoticedAndTheNextOneGoesOn) {
  const std::string whole = Y4m(0, 6);
  WriteLater({whole.substr(0, whole.size() - 1000)});  // dies within its last frame
  const auto source = OpenPipe(path_, {});
  const auto before = ReadAll(source.get());
  ASSERT_EQ(before.size(), 5U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(source->Next().status, LiveSource::Status::kNothingYet);
  // Its times had run ahead of the clock: 25 pictures a second, all sent at once.
  std::this_thread::sleep_for(milliseconds(100));
  WriteLater({Y4m(10, 4)});
  const auto frames = ReadAll(source.get());
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(NumberIn(*frames[0].picture), 10);
  EXPECT_EQ(frames[0].index, 5);
  EXPECT_GT(frames[0].timestamp, 0.1);
  EXPECT_GT(frames[0].timestamp, before.back().timestamp);
}

TEST_F(PipeSourceTest, PicturesWithoutTimesComeAfterThoseWhoseTimesRanAhead) {
  WriteLater({Y4m(0, 20)});  // 0.8 s of pictures at once
  const auto source = OpenPipe(path_, {});
  const auto before = ReadAll(source.get());
  ASSERT_EQ(before.size(), 20U);
  source->Next();
  WriteLater({Jpeg(20), Jpeg(21), Jpeg(22)});
  const auto frames = ReadAll(source.get());
  ASSERT_GE(frames.size(), 2U);
  EXPECT_GT(frames[0].timestamp, before.back().timestamp);
  EXPECT_GT(frames[1].timestamp, frames[0].timestamp);
}

TEST_F(PipeSourceTest, AWriterThatStallsIsNoticedWithinASecond) {
  const std::string whole = Y4m(0, 4);
  WriteLater({whole.substr(0, whole.size() / 2), whole.substr(whole.size() / 2)},
             milliseconds(1500));
  const auto source = OpenPipe(path_, {});
  CaptureQueue queue(source.get(), {.drop_oldest = true});
  const auto start = std::chrono::steady_clock::now();
  int before = 0, after = 0;
  double noticed = 0;
  while (after + before < 4) {
    const auto item = queue.Next(milliseconds(20));
    const std::chrono::duration<double> now = std::chrono::steady_clock::now() - start;
    ASSERT_LT(now.count(), 10);
    if (item.event == CaptureQueue::Event::kLost && noticed == 0) noticed = now.count();
    if (item.event == CaptureQueue::Event::kFrame) ++(noticed > 0 ? after : before);
  }
  EXPECT_GT(before, 0);
  EXPECT_GT(after, 0);
  EXPECT_GT(noticed, 0);
  EXPECT_LT(noticed, 1.2);
}

TEST_F(PipeSourceTest, CancelEndsAWait) {
  WriteLater({Y4m(0, 2)}, milliseconds(1500));
  const auto source = OpenPipe(path_, {});
  const auto start = std::chrono::steady_clock::now();
  std::thread canceller([&] {
    std::this_thread::sleep_for(milliseconds(100));
    source->Cancel();
  });
  while (std::chrono::steady_clock::now() - start < milliseconds(150)) source->Next();
  EXPECT_LT(std::chrono::steady_clock::now() - start, milliseconds(1000));
  canceller.join();
}

TEST_F(PipeSourceTest, WhatIsNoVideoIsRefusedByName) {
  WriteLater({std::string(1000, 'x')});
  EXPECT_NE(BadInputMessage([&] { OpenPipe(path_, {}); }).find(path_.string()), std::string::npos);
  writer_.join();
  const std::string silent = BadInputMessage([&] { OpenPipe(path_, {.open_timeout = 0.3}); });
  EXPECT_NE(silent.find("no picture came"), std::string::npos) << silent;
  EXPECT_THROW(OpenPipe(path_, {.format = "yuyv422"}), Error);
  EXPECT_THROW(OpenPipe(path_, {.format = "v210", .width = 8, .height = 8}), std::invalid_argument);
  EXPECT_THROW(OpenPipe(folder_ / "absent", {}), Error);
  EXPECT_TRUE(IsPipe(path_));
  EXPECT_TRUE(IsPipe("-"));
  EXPECT_FALSE(IsPipe(folder_));
}

}  // namespace
}  // namespace livemvs
