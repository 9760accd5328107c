#include "fifo.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <thread>

namespace livemvs::testing_support {

using std::chrono::milliseconds;

std::string Y4mHeader(int width, int height) {
  return "YUV4MPEG2 W" + std::to_string(width) + " H" + std::to_string(height) + " F30:1 Ip C420\n";
}

std::string Y4mFrame(const Picture& picture) {
  std::string bytes = "FRAME\n";
  const auto append = [&bytes](const Image<std::uint8_t>& plane) {
    for (int y = 0; y < plane.height(); ++y) {
      bytes.append(reinterpret_cast<const char*>(plane.Row(y)),
                   static_cast<std::size_t>(plane.width()));
    }
  };
  append(picture.grey);
  if (picture.cb.empty()) {
    bytes.append(2 * static_cast<std::size_t>((picture.width() + 1) / 2) *
                     static_cast<std::size_t>((picture.height() + 1) / 2),
                 static_cast<char>(128));
  } else {
    append(picture.cb);
    append(picture.cr);
  }
  return bytes;
}

Fifo::Fifo(const std::filesystem::path& path) : path_(path) {
  std::signal(SIGPIPE, SIG_IGN);
  if (::mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("no FIFO");
}

Fifo::~Fifo() { Close(); }

bool Fifo::Open() {
  for (int i = 0; i < 1000 && fd_ < 0; ++i) {
    fd_ = ::open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) std::this_thread::sleep_for(milliseconds(10));
  }
  if (fd_ < 0) return false;
  ::fcntl(fd_, F_SETFL, 0);  // from here on it waits
  return true;
}

bool Fifo::Write(const std::string& bytes, milliseconds pause) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(fd_, bytes.data() + done, bytes.size() - done);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  std::this_thread::sleep_for(pause);
  return true;
}

void Fifo::Close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

bool Fifo::Send(const std::vector<std::string>& parts) {
  bool sent = Open();
  for (const std::string& part : parts) sent = sent && Write(part, milliseconds(30));
  Close();
  return sent;
}

}  // namespace livemvs::testing_support
