// Videos out and in again: VideoWriter against OpenVideo.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <stdexcept>
#include <tuple>

#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/media_test_util.h"
#include "livemvs/io/video_source.h"
#include "livemvs/io/video_writer.h"

/// x265 leaks a kilobyte per encoder, which is not ours to mend.
extern "C" const char* __lsan_default_suppressions() { return "leak:libx265"; }

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int kVideoWidth = 160;
constexpr int kVideoHeight = 112;
/// Luma of a video at crf 18 differs from the original by less than this in the mean.
constexpr double kCodingError = 2.5;

class VideoTest : public MediaTest {
 protected:
  static VideoWriterOptions Options() {
    VideoWriterOptions options;
    options.width = kVideoWidth;
    options.height = kVideoHeight;
    return options;
  }

  /// Writes frames 0 ... count - 1.
  fs::path Make(const std::string& name, int count, const VideoWriterOptions& options) {
    const fs::path path = folder_ / name;
    VideoWriter writer(path, options);
    for (int i = 0; i < count; ++i) writer.Write(NumberedPicture(i, kVideoWidth, kVideoHeight));
    writer.Finish();
    return path;
  }

  static std::vector<SourceFrame> ReadAll(FrameSource& source) {
    std::vector<SourceFrame> frames;
    while (auto frame = source.Next()) frames.push_back(std::move(*frame));
    return frames;
  }
};

TEST_F(VideoTest, GivesBackWhatWasWritten) {
  const fs::path path = Make("a.mp4", 70, Options());
  const auto source = OpenVideo(path);
  EXPECT_EQ(source->info().width, kVideoWidth);
  EXPECT_EQ(source->info().height, kVideoHeight);
  EXPECT_EQ(source->info().frame_count, 70);
  EXPECT_DOUBLE_EQ(source->info().frames_per_second, 30);
  EXPECT_EQ(source->info().description, "H.264 video 160 x 112, 30 Hz, 70 frames");
  const auto frames = ReadAll(*source);
  ASSERT_THAT(frames, SizeIs(70));
  for (int i = 0; i < 70; ++i) {
    const SourceFrame& frame = frames[static_cast<std::size_t>(i)];
    const Picture written = NumberedPicture(i, kVideoWidth, kVideoHeight);
    EXPECT_EQ(frame.index, i);
    EXPECT_NEAR(frame.timestamp, i / 30.0, 1e-4);
    EXPECT_EQ(NumberIn(*frame.picture), i);
    EXPECT_LT(MeanDifference(frame.picture->grey, written.grey), kCodingError);
    EXPECT_LT(MeanDifference(frame.picture->cb, written.cb), kCodingError);
    EXPECT_LT(MeanDifference(frame.picture->cr, written.cr), kCodingError);
    EXPECT_FALSE(frame.picture->full_range);
    EXPECT_EQ(frame.picture->matrix, YuvMatrix::kBt709);
  }
  EXPECT_EQ(source->statistics().decoded, 70);
  EXPECT_EQ(source->statistics().skipped, 0);
  EXPECT_THAT(warnings_, IsEmpty());
  EXPECT_FALSE(source->Next());
}

TEST_F(VideoTest, LosslessLumaComesBackBitForBit) {
  VideoWriterOptions options = Options();
  options.crf = 0;
  const auto frames = ReadAll(*OpenVideo(Make("a.mkv", 5, options)));
  ASSERT_THAT(frames, SizeIs(5));
  const Picture written = NumberedPicture(4, kVideoWidth, kVideoHeight);
  EXPECT_EQ(MeanDifference(frames[4].picture->grey, written.grey), 0);
  EXPECT_EQ(MeanDifference(frames[4].picture->cr, written.cr), 0);
}

TEST_F(VideoTest, KeepsVariableFrameRate) {
  const std::vector<double> times = {0, 0.04, 0.05, 0.2, 0.21, 0.5, 1.5, 1.52};
  VideoWriter writer(folder_ / "a.mp4", Options());
  for (std::size_t i = 0; i < times.size(); ++i) {
    writer.Write(NumberedPicture(static_cast<int>(i), kVideoWidth, kVideoHeight), times[i]);
  }
  EXPECT_THROW(writer.Write(NumberedPicture(0, kVideoWidth, kVideoHeight), 1.0),
               std::invalid_argument);
  writer.Finish();
  const auto frames = ReadAll(*OpenVideo(folder_ / "a.mp4"));
  ASSERT_THAT(frames, SizeIs(times.size()));
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(frames[i].timestamp, times[i], 1e-4);
    EXPECT_EQ(NumberIn(*frames[i].picture), static_cast<int>(i));
  }
}

TEST_F(VideoTest, WritesColourAndGreyImages) {
  for (const bool full_range : {false, true}) {
    VideoWriterOptions options = Options();
    options.full_range = full_range;
    options.crf = 4;
    VideoWriter writer(folder_ / "a.mp4", options);
    Image<Rgb> rgb(kVideoWidth, kVideoHeight);
    Image<std::uint8_t> grey(kVideoWidth, kVideoHeight);
    for (int y = 0; y < kVideoHeight; ++y) {
      for (int x = 0; x < kVideoWidth; ++x) {
        rgb(x, y) = x < kVideoWidth / 2 ? Rgb{200, 60, 30} : Rgb{20, 90, 220};
        grey(x, y) = static_cast<std::uint8_t>(x);
      }
    }
    writer.Write(rgb);
    writer.Write(grey);
    writer.Finish();
    const auto frames = ReadAll(*OpenVideo(folder_ / "a.mp4"));
    ASSERT_THAT(frames, SizeIs(2));
    const Rgb left = frames[0].picture->ColorAt(20, 50);
    const Rgb right = frames[0].picture->ColorAt(140, 50);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(left[c], (Rgb{200, 60, 30}[c]), 4) << full_range;
      EXPECT_NEAR(right[c], (Rgb{20, 90, 220}[c]), 4) << full_range;
    }
    for (const int x : {5, 80, 155}) {
      EXPECT_NEAR(frames[1].picture->ColorAt(x, 60)[0], x, 4) << full_range;
    }
  }
}

TEST_F(VideoTest, RejectsOptionsAndPicturesThatMakeNoSense) {
  VideoWriterOptions options = Options();
  options.width = 161;
  EXPECT_THROW(VideoWriter(folder_ / "a.mp4", options), std::invalid_argument);
  EXPECT_THROW(VideoWriter(folder_ / "a.nonsense", Options()), std::invalid_argument);
  EXPECT_THROW(VideoWriter(folder_ / "missing" / "a.mp4", Options()), Error);
  VideoWriter writer(folder_ / "a.mp4", Options());
  EXPECT_THROW(writer.Write(NumberedPicture(0, 320, 240)), std::invalid_argument);
}

TEST_F(VideoTest, NothingAppearsWithoutFinish) {
  {
    VideoWriter writer(folder_ / "a.mp4", Options());
    for (int i = 0; i < 5; ++i) writer.Write(NumberedPicture(i, kVideoWidth, kVideoHeight));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

/// Encoder, container and what the description says.
class CodecTest
    : public VideoTest,
      public ::testing::WithParamInterface<std::tuple<const char*, const char*, const char*>> {};

TEST_P(CodecTest, CanBeRead) {
  const auto [encoder, ending, title] = GetParam();
  if (avcodec_find_encoder_by_name(encoder) == nullptr) {
    GTEST_SKIP() << "this FFmpeg has no " << encoder;
  }
  ::setenv("SVT_LOG", "-1", 1);  // SVT-AV1 prints otherwise.
  VideoWriterOptions options = Options();
  options.encoder = encoder;
  const auto source = OpenVideo(Make(std::string("a") + ending, 20, options));
  EXPECT_THAT(source->info().description, HasSubstr(title));
  const auto frames = ReadAll(*source);
  ASSERT_THAT(frames, SizeIs(20));
  for (int i = 0; i < 20; ++i) {
    const SourceFrame& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(NumberIn(*frame.picture), i);
    EXPECT_EQ(frame.index, i);
    EXPECT_NEAR(frame.timestamp, i / 30.0, 2e-3);  // Matroska counts milliseconds.
  }
  EXPECT_THAT(warnings_, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(All,
                         CodecTest,
                         ::testing::Values(std::tuple("libx264", ".mov", "H.264"),
                                           std::tuple("libx264", ".mkv", "H.264"),
                                           std::tuple("libx265", ".mp4", "HEVC"),
                                           std::tuple("libvpx", ".webm", "VP8"),
                                           std::tuple("libvpx-vp9", ".webm", "VP9"),
                                           std::tuple("mjpeg", ".avi", "Motion JPEG"),
                                           std::tuple("mpeg4", ".avi", "MPEG-4"),
                                           std::tuple("libsvtav1", ".mp4", "AV1")));

// --- Rotation ------------------------------------------------------------------------------------

/// Puts a display matrix into the track header of an MP4 file: (x', y') = (a x + c y, b x + d y).
std::string WithMatrix(std::string mp4, int a, int b, int c, int d) {
  // ISO/IEC 14496-12: 40 bytes of times, numbers, layer and volume before the matrix.
  const std::size_t at = mp4.find("tkhd") + 4 + 40;
  const int values[] = {a, b, 0, c, d};
  for (std::size_t i = 0; i < 5; ++i) {
    const auto fixed = static_cast<std::uint32_t>(values[i] * 65536);
    for (std::size_t k = 0; k < 4; ++k) {
      mp4[at + 4 * i + k] = static_cast<char>(fixed >> (24 - 8 * k));
    }
  }
  return mp4;
}

TEST_F(VideoTest, AppliesTheRotationInTheMetadata) {
  const std::string mp4 = ReadBytes(Make("a.mp4", 2, Options()));
  const Picture upright =
      std::move(const_cast<Picture&>(*ReadAll(*OpenVideo(folder_ / "a.mp4"))[0].picture));
  for (const auto& [a, b, c, d] : {std::tuple(1, 0, 0, 1),
                                   std::tuple(0, 1, -1, 0),
                                   std::tuple(-1, 0, 0, -1),
                                   std::tuple(0, -1, 1, 0),
                                   std::tuple(-1, 0, 0, 1),
                                   std::tuple(0, 1, 1, 0)}) {
    WriteBytes(folder_ / "b.mp4", WithMatrix(mp4, a, b, c, d));
    const auto source = OpenVideo(folder_ / "b.mp4");
    EXPECT_EQ(source->info().width, a == 0 ? kVideoHeight : kVideoWidth);
    const auto frames = ReadAll(*source);
    ASSERT_THAT(frames, SizeIs(2));
    const Picture& turned = *frames[0].picture;
    ASSERT_EQ(turned.width(), source->info().width);
    ASSERT_EQ(turned.height(), source->info().height);
    // Where a pixel goes, moved so that the smallest coordinate is 0.
    const int shift_x = (a < 0 ? kVideoWidth - 1 : 0) + (c < 0 ? kVideoHeight - 1 : 0);
    const int shift_y = (b < 0 ? kVideoWidth - 1 : 0) + (d < 0 ? kVideoHeight - 1 : 0);
    for (const auto& [x, y] : {std::pair(3, 7), std::pair(150, 20), std::pair(61, 101)}) {
      const int turned_x = a * x + c * y + shift_x, turned_y = b * x + d * y + shift_y;
      EXPECT_EQ(turned.grey(turned_x, turned_y), upright.grey(x, y));
      EXPECT_EQ(turned.ColorAt(turned_x, turned_y), upright.ColorAt(x, y));
    }
  }
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(VideoTest, WarnsOfAnObliqueRotation) {
  const std::string mp4 = ReadBytes(Make("a.mp4", 2, Options()));
  WriteBytes(folder_ / "b.mp4", WithMatrix(mp4, 1, 1, -1, 1));
  EXPECT_THAT(ReadAll(*OpenVideo(folder_ / "b.mp4")), SizeIs(2));
  EXPECT_THAT(warnings_, SizeIs(1));
}

// --- Damage --------------------------------------------------------------------------------------

TEST_F(VideoTest, NamesWhatIsNoVideo) {
  const auto message = [&](const std::string& name) {
    const std::string text = BadInputMessage([&] { OpenVideo(folder_ / name); });
    EXPECT_THAT(text, HasSubstr((folder_ / name).string()));
    return text;
  };
  WriteBytes(folder_ / "empty.mp4", "");
  WriteBytes(folder_ / "text.mp4", "These are words, and no video at all.\n");
  WriteBytes(folder_ / "tiny.mp4", "x");
  WriteBytes(folder_ / "zeros.mp4", std::string(1000, '\0'));
  EXPECT_THAT(message("missing.mp4"), HasSubstr("no such file"));
  EXPECT_THAT(message(""), HasSubstr("directory"));
  EXPECT_THAT(message("empty.mp4"), HasSubstr("empty"));
  EXPECT_THAT(message("text.mp4"), HasSubstr("text"));
  EXPECT_THAT(message("tiny.mp4"), HasSubstr("no MP4"));
  EXPECT_THAT(message("zeros.mp4"), HasSubstr("no MP4"));
}

TEST_F(VideoTest, NamesTheRemedyWhereTheIndexIsMissing) {
  const std::string mp4 = ReadBytes(Make("a.mp4", 30, Options()));
  const std::size_t moov = mp4.find("moov");
  ASSERT_GT(moov, mp4.size() / 2) << "the writer puts the index first";
  WriteBytes(folder_ / "cut.mp4", mp4.substr(0, moov - 4));
  EXPECT_THAT(BadInputMessage([&] { OpenVideo(folder_ / "cut.mp4"); }),
              HasSubstr("cut off before its index"));
  // The index itself cut in the middle.
  WriteBytes(folder_ / "cut.mp4", mp4.substr(0, (moov + mp4.size()) / 2));
  BadInputMessage([&] {
    const auto source = OpenVideo(folder_ / "cut.mp4");
    while (source->Next()) {
    }
  });
}

TEST_F(VideoTest, GivesWhatIsThereOfACutFile) {
  const std::string mkv = ReadBytes(Make("a.mkv", 100, Options()));
  WriteBytes(folder_ / "cut.mkv", mkv.substr(0, mkv.size() / 2));
  const auto source = OpenVideo(folder_ / "cut.mkv");
  const auto frames = ReadAll(*source);
  EXPECT_GT(frames.size(), 30u);
  EXPECT_LT(frames.size(), 70u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, static_cast<int>(i));
    EXPECT_EQ(NumberIn(*frames[i].picture), static_cast<int>(i));
  }
}

TEST_F(VideoTest, WarnsWhereTheIndexKnowsOfMoreFrames) {
  // AVI has its number of frames at the start.
  VideoWriterOptions options = Options();
  options.encoder = "mjpeg";
  const std::string avi = ReadBytes(Make("a.avi", 50, options));
  WriteBytes(folder_ / "cut.avi", avi.substr(0, avi.size() / 2));
  const auto source = OpenVideo(folder_ / "cut.avi");
  const auto frames = ReadAll(*source);
  EXPECT_GT(frames.size(), 15u);
  EXPECT_LT(frames.size(), 35u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(NumberIn(*frames[i].picture), static_cast<int>(i));
  }
  ASSERT_FALSE(warnings_.empty());
  EXPECT_THAT(warnings_[0], HasSubstr("ends early"));
}

TEST_F(VideoTest, PassesOverDamagedFramesAndKeepsTheNumbersOfTheOthers) {
  const std::string mp4 = ReadBytes(Make("a.mp4", 120, Options()));
  const std::size_t data = mp4.find("mdat") + 4;
  const std::size_t end = mp4.find("moov") - 4;
  std::string damaged = mp4;
  // Everything from 40 % to 55 % of the stream is noise; a key frame comes at least every 30.
  std::mt19937 random(7);
  for (std::size_t i = data + (end - data) * 40 / 100; i < data + (end - data) * 55 / 100; ++i) {
    damaged[i] = static_cast<char>(random());
  }
  WriteBytes(folder_ / "b.mp4", damaged);
  const auto source = OpenVideo(folder_ / "b.mp4");
  const auto frames = ReadAll(*source);
  const FrameSource::Statistics statistics = source->statistics();
  EXPECT_GT(statistics.decoded, 60);
  EXPECT_GT(statistics.skipped, 10);
  EXPECT_EQ(statistics.decoded + statistics.skipped, 120);
  EXPECT_EQ(frames.size(), static_cast<std::size_t>(statistics.decoded));
  int ghosts = 0;
  // B frames may be shown before the damaged frame that they refer to is missed.
  constexpr int kMaxGhosts = 3;
  for (const SourceFrame& frame : frames) {
    EXPECT_NEAR(frame.timestamp, static_cast<double>(frame.index) / 30, 1e-4);
    const Picture written =
        NumberedPicture(static_cast<int>(frame.index), kVideoWidth, kVideoHeight);
    ghosts += MeanDifference(frame.picture->grey, written.grey) > kCodingError;
  }
  EXPECT_LE(ghosts, kMaxGhosts);
  EXPECT_EQ(frames.back().index, 119);
  ASSERT_THAT(warnings_, SizeIs(1));
  EXPECT_THAT(warnings_[0], HasSubstr("were passed over"));
}

TEST_F(VideoTest, CountsWhatDamageTookWhetherItWaitsForAKeyFrameOrNot) {
  const std::string mp4 = ReadBytes(Make("a.mp4", 120, Options()));
  // Frame 33 or so, soon after the key frame 30: its first bytes are lost.
  std::string damaged = mp4;
  const std::size_t data = mp4.find("mdat") + 4;
  const std::size_t at = data + (mp4.find("moov") - data) * 30 / 100;
  damaged.replace(at, 200, 200, '\x55');
  WriteBytes(folder_ / "b.mp4", damaged);
  VideoSourceOptions options;
  const auto waiting = OpenVideo(folder_ / "b.mp4", options);
  options.keep_suspect_frames = true;
  const auto keeping = OpenVideo(folder_ / "b.mp4", options);
  const std::size_t strict = ReadAll(*waiting).size();
  const std::size_t all = ReadAll(*keeping).size();
  EXPECT_GE(strict, 80u);
  EXPECT_GE(all, 80u);
  EXPECT_EQ(waiting->statistics().skipped, 120 - static_cast<std::int64_t>(strict));
  EXPECT_EQ(keeping->statistics().skipped, 120 - static_cast<std::int64_t>(all));
}

TEST_F(VideoTest, SurvivesRandomDamageAnywhere) {
  std::mt19937 random(3);
  int readable = 0;
  for (const char* name : {"a.mp4", "a.mkv", "a.avi"}) {
    VideoWriterOptions options = Options();
    if (name[2] == 'a') options.encoder = "mjpeg";
    const std::string good = ReadBytes(Make(name, 12, options));
    for (int trial = 0; trial < 60; ++trial) {
      std::string bad = good;
      for (int flip = 0; flip < 10; ++flip)
        bad[random() % bad.size()] = static_cast<char>(random());
      if (trial % 3 == 0) bad.resize(random() % bad.size());
      WriteBytes(folder_ / "bad", bad);
      try {
        const auto source = OpenVideo(folder_ / "bad");
        std::int64_t before = -1;
        while (auto frame = source->Next()) {
          EXPECT_GT(frame->index, before);
          before = frame->index;
          ASSERT_EQ(frame->picture->width(), source->info().width);
        }
        ++readable;
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kBadInput) << error.what();
      }
    }
  }
  EXPECT_GT(readable, 30);
}

TEST(VideoExtension, IgnoresCase) {
  EXPECT_TRUE(HasVideoExtension("a/B.MP4"));
  EXPECT_TRUE(HasVideoExtension("c.webm"));
  EXPECT_FALSE(HasVideoExtension("a.mp4.txt"));
  EXPECT_FALSE(HasVideoExtension("mp4"));
}

}  // namespace
}  // namespace livemvs
