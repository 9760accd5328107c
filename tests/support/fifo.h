#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "livemvs/core/frame.h"

namespace livemvs::testing_support {

/// What a y4m stream of such pictures begins with.
std::string Y4mHeader(int width, int height);

/// A picture of it; one without colours is grey.
std::string Y4mFrame(const Picture& picture);

/// A FIFO that is written to as a camera's program does.
class Fifo {
 public:
  /// Makes it. A reader that goes away is no signal for this process from here on.
  explicit Fifo(const std::filesystem::path& path);
  ~Fifo();
  Fifo(const Fifo&) = delete;
  Fifo& operator=(const Fifo&) = delete;

  /// Waits for a reader, for up to ten seconds. False where nobody comes.
  bool Open();
  /// Writes something, then pauses. False where the reader has gone.
  bool Write(const std::string& bytes, std::chrono::milliseconds pause);
  /// Goes away.
  void Close();

  /// Open, all the parts, close.
  bool Send(const std::vector<std::string>& parts);

 private:
  std::filesystem::path path_;
  int fd_ = -1;
};

}  // namespace livemvs::testing_support
