#pragma once

/// What the tests of pictures and videos share.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/core/frame.h"
#include "livemvs/core/log.h"

namespace livemvs {

/// A fresh folder per test, and the warnings that were logged.
class MediaTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              (std::string(info->test_suite_name()) + "_" + info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    SetLogCallback([this](LogLevel level, const std::string& message) {
      if (level == LogLevel::kWarning) warnings_.push_back(message);
    });
  }
  void TearDown() override {
    SetLogCallback({});
    std::filesystem::remove_all(folder_);
  }

  static std::string ReadBytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
  }

  /// The message of the Error (kBadInput) that `f` must throw.
  template <typename F>
  static std::string BadInputMessage(F&& f) {
    try {
      f();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
  }

  std::filesystem::path folder_;
  std::vector<std::string> warnings_;
};

constexpr int kCodeBits = 8;
constexpr int kCodeSide = 16;  ///< [px]

/// A 4:2:0 picture with waves that move from frame to frame, and the frame's number as a row of
/// black and white squares at the top left.
inline Picture NumberedPicture(int number, int width, int height) {
  Picture picture;
  picture.matrix = YuvMatrix::kBt709;
  picture.grey = Image<std::uint8_t>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double wave = std::sin(0.15 * (x + 2 * number)) * std::cos(0.11 * (y - number));
      picture.grey(x, y) = static_cast<std::uint8_t>(126 + 60 * wave);
      if (y < kCodeSide && x < kCodeBits * kCodeSide) {
        picture.grey(x, y) = (number >> (x / kCodeSide)) & 1 ? 235 : 16;
      }
    }
  }
  picture.chroma_shift_x = picture.chroma_shift_y = 1;
  picture.cb = Image<std::uint8_t>(width / 2, height / 2);
  picture.cr = Image<std::uint8_t>(width / 2, height / 2);
  for (int y = 0; y < height / 2; ++y) {
    for (int x = 0; x < width / 2; ++x) {
      picture.cb(x, y) = static_cast<std::uint8_t>(100 + x % 50);
      picture.cr(x, y) = static_cast<std::uint8_t>(160 - y % 40);
    }
  }
  return picture;
}

/// The number that NumberedPicture wrote.
inline int NumberIn(const Picture& picture) {
  int number = 0;
  for (int bit = 0; bit < kCodeBits; ++bit) {
    if (picture.grey(bit * kCodeSide + kCodeSide / 2, kCodeSide / 2) > 126) number |= 1 << bit;
  }
  return number;
}

inline double MeanDifference(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  EXPECT_EQ(a.width(), b.width());
  EXPECT_EQ(a.height(), b.height());
  double sum = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) sum += std::abs(a(x, y) - b(x, y));
  }
  return sum / (static_cast<double>(a.width()) * a.height());
}

}  // namespace livemvs
