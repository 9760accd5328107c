#include "livemvs/io/pipe_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr int kPollMs = 100;

}  // namespace

PipeReader::PipeReader(const std::filesystem::path& path) : path_(path) {
  if (path == "-") {
    fd_ = STDIN_FILENO;
    return;
  }
  std::error_code error;
  is_fifo_ = std::filesystem::is_fifo(path, error);
  if (!is_fifo_) throw BadInput(path.string() + ": is no pipe (FIFO)");
  fd_ = OpenFifo();
  if (fd_ < 0) {
    throw BadInput(path.string() +
                   ": cannot be opened for reading: " + std::generic_category().message(errno));
  }
}

PipeReader::~PipeReader() {
  if (is_fifo_ && fd_ >= 0) ::close(fd_);
}

// Without waiting for a writer.
int PipeReader::OpenFifo() const {
  return ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
}

std::size_t PipeReader::Read(std::uint8_t* data, std::size_t size) {
  if (!peeked_.empty()) {
    const std::size_t n = std::min(size, peeked_.size());
    std::copy_n(peeked_.begin(), n, data);
    peeked_.erase(peeked_.begin(), peeked_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }
  while (!cancelled_ && !(give_up && give_up())) {
    pollfd poll_fd{fd_, POLLIN, 0};
    const int ready = ::poll(&poll_fd, 1, kPollMs);
    if (ready <= 0) continue;  // nothing yet, or a signal
    const ssize_t n = ::read(fd_, data, size);
    if (n > 0) {
      had_writer_ = true;
      return static_cast<std::size_t>(n);
    }
    if (n == 0 || (errno != EAGAIN && errno != EINTR)) return 0;
  }
  return 0;
}

std::vector<std::uint8_t> PipeReader::Peek(std::size_t size) {
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < size) {
    const std::size_t before = bytes.size();
    bytes.resize(size);
    const std::size_t n = Read(bytes.data() + before, size - before);
    bytes.resize(before + n);
    if (n == 0) break;
  }
  peeked_.insert(peeked_.begin(), bytes.begin(), bytes.end());
  return bytes;
}

bool PipeReader::WaitForWriter() {
  if (!is_fifo_) return false;
  if (had_writer_) {
    // The end of one writer's bytes is remembered by what is open; open it anew, and only then
    // close it, so that it has a reader all the time.
    const int fresh = OpenFifo();
    if (fresh < 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kPollMs));
      return false;
    }
    ::close(fd_);
    fd_ = fresh;
    had_writer_ = false;
    peeked_.clear();
  }
  pollfd poll_fd{fd_, POLLIN, 0};
  return ::poll(&poll_fd, 1, kPollMs) > 0 && (poll_fd.revents & POLLIN) != 0;
}

}  // namespace livemvs
