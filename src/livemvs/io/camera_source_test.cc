// The layer between a camera's driver and the program, against a driver that is made up: there is
// no camera where tests run. What a real driver sends is for the eye, see docs/scanning.md.

#include "livemvs/io/camera_source.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>

#include "livemvs/io/capture_queue.h"
#include "livemvs/io/fake_v4l2.h"
#include "livemvs/io/media_test_util.h"
#include "livemvs/io/video_writer.h"

namespace livemvs {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr int kWidth = 160, kHeight = 96, kPictures = 30;

std::string Yuyv(int number, int padding = 0) {
  const Picture picture = NumberedPicture(number, kWidth, kHeight);
  std::string bytes;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      bytes += static_cast<char>(picture.grey(x, y));
      bytes += static_cast<char>((x % 2 == 0 ? picture.cb : picture.cr)(x / 2, y / 2));
    }
    bytes += std::string(static_cast<std::size_t>(padding), 'p');
  }
  return bytes;
}

std::string Nv12(int number) {
  const Picture picture = NumberedPicture(number, kWidth, kHeight);
  std::string bytes;
  for (int y = 0; y < kHeight; ++y) {
    bytes.append(reinterpret_cast<const char*>(picture.grey.Row(y)), kWidth);
  }
  for (int y = 0; y < kHeight / 2; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      bytes += static_cast<char>(picture.cb(x, y));
      bytes += static_cast<char>(picture.cr(x, y));
    }
  }
  return bytes;
}

class CameraSourceTest : public MediaTest {
 protected:
  void SetUp() override {
    MediaTest::SetUp();
    for (int i = 0; i < kPictures; ++i) camera_.pictures[V4L2_PIX_FMT_YUYV].push_back(Yuyv(i));
  }

  // The next picture; fails where none comes in 3 s.
  static SourceFrame NextFrame(LiveSource* source) {
    const auto start = Clock::now();
    while (Clock::now() - start < milliseconds(3000)) {
      LiveSource::Answer answer = source->Next();
      if (answer.status == LiveSource::Status::kFrame) return std::move(answer.frame);
    }
    ADD_FAILURE() << "no picture";
    return {};
  }

  std::string Jpeg(int number) const {
    VideoWriterOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.encoder = "mjpeg";
    options.full_range = true;
    VideoWriter writer(folder_ / "jpeg.avi", options);
    writer.Write(NumberedPicture(number, kWidth, kHeight));
    writer.Finish();
    const std::string avi = ReadBytes(folder_ / "jpeg.avi");
    const std::size_t begin = avi.find("\xFF\xD8\xFF");
    return avi.substr(begin, avi.rfind("\xFF\xD9") + 2 - begin);
  }

  FakeV4l2 camera_;
};

TEST_F(CameraSourceTest, ListsCamerasWithTheModesThatCanBeRead) {
  camera_.pictures[V4L2_PIX_FMT_MJPEG];
  const auto cameras = ListCameras(camera_);
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].path, "/dev/video2");
  EXPECT_EQ(cameras[0].name, "Fake camera");
  ASSERT_EQ(cameras[0].modes.size(), 8U) << "two formats, two sizes, two rates";
  EXPECT_EQ(camera_.opened, 0);
  camera_.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_TRUE(ListCameras(camera_).empty()) << "webcams have such devices, too";
  camera_.plugged_in = false;
  EXPECT_TRUE(ListCameras(camera_).empty());
}

TEST_F(CameraSourceTest, GivesRawPicturesToThePixelWithTheDriversTimes) {
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96@30")}, camera_);
  EXPECT_EQ(source->info().width, kWidth);
  EXPECT_EQ(source->info().frames_per_second, 30);
  EXPECT_EQ(camera_.rate_set, 30);
  constexpr double kMicroseconds = 3e-5;
  for (int i = 0; i < 10; ++i) {
    const SourceFrame frame = NextFrame(source.get());
    EXPECT_EQ(frame.index, i);
    EXPECT_NEAR(frame.timestamp, i / 30.0, kMicroseconds);
    EXPECT_EQ(MeanDifference(frame.picture->grey, NumberedPicture(i, kWidth, kHeight).grey), 0);
    EXPECT_EQ(frame.picture->cb(3, 4), NumberedPicture(i, kWidth, kHeight).cb(3, 2));
  }
}

TEST_F(CameraSourceTest, KnowsPaddedLines) {
  auto& pictures = camera_.pictures[V4L2_PIX_FMT_YUYV];
  for (int i = 0; i < kPictures; ++i) pictures[i] = Yuyv(i, 24);
  camera_.line_padding = 24;
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96")}, camera_);
  const SourceFrame frame = NextFrame(source.get());
  EXPECT_EQ(MeanDifference(frame.picture->grey, NumberedPicture(0, kWidth, kHeight).grey), 0);
}

TEST_F(CameraSourceTest, ReadsNv12AndMotionJpeg) {
  for (int i = 0; i < 5; ++i) {
    camera_.pictures[V4L2_PIX_FMT_NV12].push_back(Nv12(i));
    camera_.pictures[V4L2_PIX_FMT_MJPEG].push_back(Jpeg(i));
  }
  {
    const auto source = OpenCamera("2", {.mode = ParseMode("160x96:nv12")}, camera_);
    const SourceFrame frame = NextFrame(source.get());
    EXPECT_EQ(MeanDifference(frame.picture->grey, NumberedPicture(0, kWidth, kHeight).grey), 0);
    EXPECT_EQ(MeanDifference(frame.picture->cr, NumberedPicture(0, kWidth, kHeight).cr), 0);
  }
  camera_.sent = 0;
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96:mjpeg")}, camera_);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(NumberIn(*NextFrame(source.get()).picture), i);
}

TEST_F(CameraSourceTest, DamagedPicturesAreCountedAndPassedOver) {
  camera_.flags_of[2] = V4L2_BUF_FLAG_ERROR;
  camera_.bytes_used_of[4] = 1000;       // cut short
  camera_.bytes_used_of[6] = 4'000'000;  // more than there is room for
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96")}, camera_);
  std::vector<int> numbers;
  for (int i = 0; i < 6; ++i) numbers.push_back(NumberIn(*NextFrame(source.get()).picture));
  EXPECT_EQ(numbers, (std::vector<int>{0, 1, 3, 5, 7, 8}));
  EXPECT_EQ(source->statistics().skipped, 3);
}

TEST_F(CameraSourceTest, AnUnpluggedCameraIsNoticedWithinASecondAndComesBackElsewhere) {
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96")}, camera_);
  CaptureQueue queue(source.get(), {.drop_oldest = true});
  ASSERT_EQ(queue.Next(milliseconds(2000)).event, CaptureQueue::Event::kFrame);
  {
    const std::lock_guard<std::recursive_mutex> lock(camera_.mutex);
    camera_.plugged_in = false;
  }
  const auto start = Clock::now();
  CaptureQueue::Item item;
  while (item.event != CaptureQueue::Event::kLost && Clock::now() - start < milliseconds(3000)) {
    item = queue.Next(milliseconds(20));
  }
  EXPECT_EQ(item.event, CaptureQueue::Event::kLost);
  EXPECT_NE(item.problem.find("unplugged"), std::string::npos) << item.problem;
  EXPECT_LT(Clock::now() - start, milliseconds(1000));
  {
    const std::lock_guard<std::recursive_mutex> lock(camera_.mutex);
    camera_.plugged_in = true;
    camera_.path = "/dev/video5";
  }
  item = queue.Next(milliseconds(3000));
  EXPECT_EQ(item.event, CaptureQueue::Event::kFrame);
}

TEST_F(CameraSourceTest, ASilentCameraIsStartedAnew) {
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96")}, camera_);
  NextFrame(source.get());
  camera_.silent = true;
  const auto start = Clock::now();
  LiveSource::Answer answer;
  while (answer.status != LiveSource::Status::kLost && Clock::now() - start < milliseconds(5000)) {
    answer = source->Next();
  }
  EXPECT_EQ(answer.status, LiveSource::Status::kLost);
  camera_.silent = false;
  const SourceFrame frame = NextFrame(source.get());
  EXPECT_NE(frame.picture, nullptr);
}

TEST_F(CameraSourceTest, TimesOfAnotherClockAreReplacedByThoseOfArrival) {
  for (int i = 0; i < 100; ++i) camera_.flags_of[i] = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  const auto source = OpenCamera("2", {.mode = ParseMode("160x96")}, camera_);
  double last = -1;
  for (int i = 0; i < 5; ++i) {
    const double time = NextFrame(source.get()).timestamp;
    EXPECT_GT(time, last);
    last = time;
  }
  EXPECT_LT(last, 1);
}

TEST_F(CameraSourceTest, ControlsAreLockedAtTheirPresentValues) {
  const auto source =
      OpenCamera("2", {.mode = ParseMode("160x96"), .lock_controls = true}, camera_);
  const auto start = Clock::now();
  while (Clock::now() - start < milliseconds(1200)) NextFrame(source.get());
  EXPECT_EQ(camera_.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(camera_.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 123);
  EXPECT_EQ(camera_.controls[V4L2_CID_FOCUS_AUTO], 0);
}

TEST_F(CameraSourceTest, WhatCannotBeOpenedIsToldWithTheRemedy) {
  const auto message = [&](const std::string& device, const char* mode) {
    return BadInputMessage([&] { OpenCamera(device, {.mode = ParseMode(mode)}, camera_); });
  };
  EXPECT_NE(message("7", "").find("/dev/video7: the camera is not there"), std::string::npos);
  const std::string no_mode = message("2", "1920x1080");
  EXPECT_NE(no_mode.find("160x96@30:yuyv"), std::string::npos) << no_mode;
  camera_.refuses_formats = true;
  EXPECT_NE(message("2", "160x96").find("80x96"), std::string::npos);
  camera_.refuses_formats = false;
  camera_.busy = true;
  EXPECT_NE(message("2", "").find("in use"), std::string::npos);
  camera_.busy = false;
  camera_.capabilities = V4L2_CAP_VIDEO_OUTPUT;
  EXPECT_NE(message("2", "").find("no camera"), std::string::npos);
  EXPECT_EQ(camera_.opened, 0) << "everything is closed";
  EXPECT_EQ(camera_.mapped, 0);
}

TEST(CameraModes, WishesAreParsed) {
  const ModeWish all = ParseMode("1280x720@29.97:mjpeg");
  EXPECT_EQ(all.width, 1280);
  EXPECT_EQ(all.height, 720);
  EXPECT_EQ(all.rate, 29.97);
  EXPECT_EQ(all.format, "mjpeg");
  EXPECT_EQ(ParseMode("@60").rate, 60);
  EXPECT_EQ(ParseMode(":yuyv").format, "yuyv");
  EXPECT_EQ(ParseMode("").width, 0);
  for (const char* bad : {"1280", "1280x", "x720", "1280x720@", "1280x720:bmp", "a", "1x1@1?"}) {
    EXPECT_THROW(ParseMode(bad), std::invalid_argument) << bad;
  }
}

TEST(CameraModes, TheBestThatFitsIsChosen) {
  const std::vector<CameraMode> modes = {{"yuyv", 1280, 720, 10},
                                         {"mjpeg", 1280, 720, 30},
                                         {"yuyv", 640, 480, 30},
                                         {"mjpeg", 3840, 2160, 30},
                                         {"mjpeg", 1280, 720, 60}};
  EXPECT_EQ(ToString(*ChooseMode(modes, {})), "1280x720@60:mjpeg");
  EXPECT_EQ(ToString(*ChooseMode(modes, ParseMode(":yuyv"))), "640x480@30:yuyv");
  EXPECT_EQ(ToString(*ChooseMode(modes, ParseMode("1280x720@30"))), "1280x720@30:mjpeg");
  EXPECT_FALSE(ChooseMode(modes, ParseMode("800x600")));
}

}  // namespace
}  // namespace livemvs
