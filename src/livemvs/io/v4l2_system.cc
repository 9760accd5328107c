#include "livemvs/io/v4l2_system.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace livemvs {
namespace {

class System final : public V4l2System {
 public:
  std::vector<std::string> Devices() override {
    constexpr int kMostDevices = 64;
    std::vector<std::string> paths;
    for (int i = 0; i < kMostDevices; ++i) {
      const std::string path = "/dev/video" + std::to_string(i);
      std::error_code error;
      if (std::filesystem::is_character_file(path, error)) paths.push_back(path);
    }
    return paths;
  }

  int Open(const std::string& path) override {
    return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  }

  void Close(int fd) override { ::close(fd); }

  int Ioctl(int fd, unsigned long request, void* argument) override {
    int result = 0;
    do {
      result = ::ioctl(fd, request, argument);
    } while (result < 0 && errno == EINTR);
    return result;
  }

  void* Map(int fd, std::size_t length, std::size_t offset) override {
    void* memory =
        ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : memory;
  }

  void Unmap(void* memory, std::size_t length) override { ::munmap(memory, length); }

  Ready Wait(int fd, int timeout_ms) override {
    pollfd poll_fd{fd, POLLIN, 0};
    const int ready = ::poll(&poll_fd, 1, timeout_ms);
    if (ready < 0) return errno == EINTR ? Ready::kNo : Ready::kBroken;
    if (ready == 0) return Ready::kNo;
    return (poll_fd.revents & POLLIN) != 0 ? Ready::kYes : Ready::kBroken;
  }
};

}  // namespace

V4l2System& RealV4l2System() {
  static System system;
  return system;
}

}  // namespace livemvs
