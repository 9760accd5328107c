#pragma once

/// The system calls through which cameras are reached. Private to io/.

#include <cstddef>
#include <string>
#include <vector>

namespace livemvs {

/// A seam for tests: faults of cameras cannot be produced without one. Calls behave as the system's
/// of the same name, errors in errno; ioctl is repeated where a signal came.
class V4l2System {
 public:
  virtual ~V4l2System() = default;

  /// Paths of the video devices that there are, by their numbers.
  virtual std::vector<std::string> Devices() = 0;
  virtual int Open(const std::string& path) = 0;
  virtual void Close(int fd) = 0;
  virtual int Ioctl(int fd, unsigned long request, void* argument) = 0;
  /// nullptr where it fails.
  virtual void* Map(int fd, std::size_t length, std::size_t offset) = 0;
  virtual void Unmap(void* memory, std::size_t length) = 0;

  enum class Ready { kYes, kNo, kBroken };
  /// Whether there is something to read.
  virtual Ready Wait(int fd, int timeout_ms) = 0;
};

/// The real one.
V4l2System& RealV4l2System();

}  // namespace livemvs
