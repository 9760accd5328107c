#pragma once

/// Bytes as a file, for readers that take a path.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

namespace livemvs {

/// A file in memory, which goes with this.
class FileInput {
 public:
  explicit FileInput(std::span<const std::uint8_t> bytes) : fd_(memfd_create("fuzz", 0)) {
    if (fd_ < 0) std::abort();
    Append(bytes);
  }
  ~FileInput() { ::close(fd_); }
  FileInput(const FileInput&) = delete;
  FileInput& operator=(const FileInput&) = delete;

  void Append(std::span<const std::uint8_t> bytes) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written != static_cast<ssize_t>(bytes.size())) std::abort();
  }
  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

}  // namespace livemvs
