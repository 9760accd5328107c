// 'livemvs calibrate', 'track' and 'scan' as programs that find the camera from a printed board.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "fifo.h"
#include "livemvs/io/calibration.h"
#include "livemvs/synth/sequence.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/film.h"
#include "process.h"

namespace livemvs {
namespace {

using testing_support::Fifo;
using testing_support::Process;
namespace fs = std::filesystem;

constexpr int kSize = 480;            // of the pictures from a pipe [px]
constexpr double kFocalError = 0.01;  // of a calibration from small pictures [relative]
constexpr std::chrono::milliseconds kFrameTime{33};

class BoardProcess : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("board_process_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    WriteBoard(folder_ / "board.json", Board());
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Calibrates from the FIFO "camera" to camera.yaml.
  std::vector<std::string> Calibrate(const std::string& patience) const {
    return {LIVEMVS_PROGRAM,
            "calibrate",
            "--data",
            (folder_ / "camera").string(),
            "--board",
            (folder_ / "board.json").string(),
            "-o",
            (folder_ / "camera.yaml").string(),
            "--patience",
            patience};
  }

  // A rendered sheet that somebody goes around by an angle [degrees].
  fs::path Sheet(int frames, const std::string& arc) const {
    const fs::path path = folder_ / "sheet";
    Process synth({LIVEMVS_PROGRAM,
                   "synth",
                   "--scene",
                   "sheet",
                   "--frames",
                   std::to_string(frames),
                   "--arc",
                   arc,
                   "--size",
                   "640x480",
                   "--spp",
                   "1",
                   "--no-mesh",
                   "--progress",
                   "none",
                   "-o",
                   path.string()});
    EXPECT_EQ(synth.Wait(), 0) << synth.text();
    return path;
  }

  fs::path folder_;
};

// A camera's stream: the pictures again and again, at a camera's pace.
std::vector<std::string> Stream(const Camera& camera, std::size_t most) {
  std::vector<std::string> parts{testing_support::Y4mHeader(camera.width, camera.height)};
  for (Image<std::uint8_t>& grey : FilmFromAllSides(camera)) {
    if (parts.size() > most) break;
    Picture picture;
    picture.grey = std::move(grey);
    parts.push_back(testing_support::Y4mFrame(picture));
  }
  return parts;
}

TEST_F(BoardProcess, CalibratesACameraFromAPipeAndEndsWhenNothingIsMissing) {
  const Camera truth = SyntheticCamera(kSize, kSize);
  const std::vector<std::string> stream = Stream(truth, 40);
  Fifo fifo(folder_ / "camera");
  Process calibrate(Calibrate("10"));
  ASSERT_TRUE(fifo.Open()) << calibrate.text();
  ASSERT_TRUE(fifo.Write(stream[0], {}));
  const auto start = std::chrono::steady_clock::now();
  // It ends by itself, and goes away from the pipe.
  bool reads = true;
  for (std::size_t i = 0; reads; i = (i + 1) % (stream.size() - 1)) {
    reads = fifo.Write(stream[i + 1], kFrameTime);
    ASSERT_LT(std::chrono::steady_clock::now() - start, std::chrono::minutes(2))
        << calibrate.text();
  }
  EXPECT_EQ(calibrate.Wait(), 0) << calibrate.text();
  const std::string text = calibrate.text();
  EXPECT_NE(text.find("pipe of rawvideo pictures, 480 x 480"), std::string::npos) << text;
  EXPECT_NE(text.find(" views; "), std::string::npos) << "says what to film: " << text;
  EXPECT_EQ(text.find("lost"), std::string::npos) << text;
  const Camera found = ReadOpenCvYaml(folder_ / "camera.yaml");
  EXPECT_EQ(found.width, kSize);
  EXPECT_NEAR(found.fx, truth.fx, kFocalError * truth.fx) << text;
  EXPECT_NEAR(found.cx, truth.cx, 0.01 * kSize) << text;
}

TEST_F(BoardProcess, SaysWhyACalibrationFromAPipeThatBreaksOffIsNone) {
  const std::vector<std::string> stream = Stream(SyntheticCamera(kSize, kSize), 4);
  Fifo fifo(folder_ / "camera");
  Process calibrate(Calibrate("3"));
  ASSERT_TRUE(fifo.Send(stream)) << calibrate.text();
  EXPECT_EQ(calibrate.Wait(), 1) << calibrate.text();
  const std::string text = calibrate.text();
  EXPECT_NE(text.find("its writer has gone"), std::string::npos) << text;
  EXPECT_NE(text.find("no good calibration: only "), std::string::npos) << text;
  EXPECT_FALSE(fs::exists(folder_ / "camera.yaml"));
}

TEST_F(BoardProcess, FindsTheCameraOfARecordingInAPassOfItsOwn) {
  const fs::path sheet = Sheet(40, "80");
  Process track({LIVEMVS_PROGRAM,
                 "track",
                 "--data",
                 sheet.string(),
                 "--board",
                 (sheet / "board.json").string(),
                 "--camera",
                 "self",
                 "--camera-output",
                 (folder_ / "found.yaml").string(),
                 "-o",
                 (folder_ / "poses.txt").string()});
  EXPECT_EQ(track.Wait(), 0) << track.text();
  const std::string text = track.text();
  EXPECT_NE(text.find("no calibration given: found focal length"), std::string::npos) << text;
  // The first frames, too, have poses.
  EXPECT_NE(text.find("tracked 40 of 40 frames"), std::string::npos) << text;
  const Camera truth = SyntheticCamera(640, 480);
  const Camera found = ReadOpenCvYaml(folder_ / "found.yaml");
  EXPECT_NEAR(found.fx, truth.fx, kFocalError * truth.fx) << text;
  EXPECT_EQ(found.fx, found.fy);
}

TEST_F(BoardProcess, SaysWhatARecordingWithTooLittleTurningLacks) {
  const fs::path sheet = Sheet(12, "2");
  for (const char* command : {"track", "scan"}) {
    const fs::path output = folder_ / command;
    Process process({LIVEMVS_PROGRAM,
                     command,
                     "--data",
                     sheet.string(),
                     "--board",
                     (sheet / "board.json").string(),
                     std::string(command) == "scan" ? "--calibration" : "--camera",
                     "self",
                     "-o",
                     output.string()});
    EXPECT_EQ(process.Wait(), 1) << process.text();
    const std::string text = process.text();
    EXPECT_NE(text.find("could not be calibrated from this recording"), std::string::npos) << text;
    EXPECT_NE(text.find("film further around the board"), std::string::npos) << text;
    EXPECT_NE(text.find("move it around the board"), std::string::npos) << text;
    EXPECT_FALSE(fs::exists(output)) << text;
  }
}

}  // namespace
}  // namespace livemvs
