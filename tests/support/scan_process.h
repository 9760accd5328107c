#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "process.h"

namespace livemvs {

/// 'livemvs scan' as a process, on a short recording with poses.
class ScanProcess : public ::testing::Test {
 protected:
  static constexpr int kFrames = 60;  // 2 s

  void SetUp() override;
  void TearDown() override;

  /// The recording, made once; a folder with poses.
  static std::filesystem::path Recording();
  std::vector<std::string> ScanCommand(const std::vector<std::string>& more = {}) const;
  std::vector<std::string> ResumeCommand() const;

  /// Waits until the journal has begun and holds so many frames and points; false where it does
  /// not within a minute.
  bool WaitForJournal(std::size_t frames, std::size_t points) const;

  /// All frames are there once, and the results can be read.
  void ExpectWhole() const;

  std::filesystem::path folder_, scan_;
};

}  // namespace livemvs
