#include "process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <utility>

namespace livemvs::testing_support {

Process::Process(std::vector<std::string> command, const std::function<void()>& prepare) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  std::vector<char*> arguments;
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("no process");
  if (pid_ == 0) {
    ::dup2(ends[1], STDERR_FILENO);
    ::dup2(ends[1], STDOUT_FILENO);
    if (prepare) prepare();
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  reader_ = std::thread([this, fd = ends[0]] { Read(fd); });
}

Process::~Process() {
  if (!waited_) Kill(SIGKILL);
  Wait();
}

void Process::Kill(int signal) const { ::kill(pid_, signal); }

int Process::Wait() {
  if (!waited_) {
    ::waitpid(pid_, &status_, 0);
    reader_.join();
    waited_ = true;
  }
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

void Process::Read(int fd) {
  std::string open;
  char bytes[4096];
  while (true) {
    const ssize_t n = ::read(fd, bytes, sizeof(bytes));
    if (n <= 0) break;
    const std::lock_guard<std::mutex> lock(mutex_);
    for (ssize_t i = 0; i < n; ++i) {
      if (bytes[i] != '\n') {
        open += bytes[i];
        continue;
      }
      lines_.push_back({Clock::now(), std::exchange(open, {})});
    }
  }
  ::close(fd);
}

std::vector<Process::Line> Process::lines() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return lines_;
}

std::string Process::text() {
  std::string all;
  for (const Line& line : lines()) all += line.text + "\n";
  return all;
}

bool Process::WaitFor(const std::string& text_wanted) {
  const auto start = Clock::now();
  while (Clock::now() - start < std::chrono::minutes(1)) {
    if (text().find(text_wanted) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

PauseWatch::PauseWatch()
    : thread_([this] {
        constexpr std::chrono::milliseconds kTick{10}, kPause{100};
        auto last = Process::Clock::now();
        while (!stop_) {
          std::this_thread::sleep_for(kTick);
          const auto now = Process::Clock::now();
          const auto pause = std::chrono::duration_cast<std::chrono::milliseconds>(now - last);
          if (pause > kPause) milliseconds_ += pause.count();
          last = now;
        }
      }) {}

PauseWatch::~PauseWatch() {
  stop_ = true;
  thread_.join();
}

double PauseWatch::Total() const { return 1e-3 * static_cast<double>(milliseconds_); }

}  // namespace livemvs::testing_support
