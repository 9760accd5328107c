#include "live_view.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "livemvs/core/log.h"

namespace livemvs::app {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(20);

// A page of our own that leads to the address. Only its owner may read it.
std::filesystem::path WriteRedirect(const std::string& url) {
  const char* folder = std::getenv("XDG_RUNTIME_DIR");
  std::string path =
      (folder != nullptr ? std::filesystem::path(folder) : std::filesystem::temp_directory_path()) /
      "livemvs-XXXXXX.html";
  const int fd = mkstemps(path.data(), 5);
  if (fd < 0) return {};
  const std::string html =
      "<!doctype html><meta charset=\"utf-8\"><title>livemvs</title>"
      "<meta http-equiv=\"refresh\" content=\"0;url=" +
      url + "\">\n";
  const bool written = ::write(fd, html.data(), html.size()) == static_cast<ssize_t>(html.size());
  ::close(fd);
  return written ? std::filesystem::path(path) : std::filesystem::path();
}

bool OpenInBrowser(const std::filesystem::path& file) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return false;
  std::string program = "xdg-open", argument = file;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program.c_str(), &quiet, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&quiet);
  if (failed != 0) return false;
  std::thread([child] { waitpid(child, nullptr, 0); }).detach();
  return true;
}

}  // namespace

void AddPageOptions(CLI::App* command, PageOptions* options, bool with_flag) {
  if (with_flag) {
    command->add_flag("--view", options->view, "Show the model in a browser while it grows");
  } else {
    options->view = true;
  }
  command->add_flag(
      "--no-browser", options->no_browser, "Do not open a browser, only print the address");
  if (with_flag) {
    command->add_flag("--wait", options->wait, "With --view: wait until the page says start");
  }
  command->add_option("--listen",
                      options->listen,
                      "Address for the viewer (127.0.0.1); others are served over TLS alone");
  command->add_option("--port", options->port, "Port for the viewer (7451, or a free one)");
}

viewer::ServerOptions MakeServerOptions(const PageOptions& options, const std::string& title) {
  viewer::ServerOptions server;
  server.address = options.listen;
  server.port = options.port;
  server.title = title;
  server.tls = options.listen.rfind("127.", 0) != 0;
  return server;
}

OpenedPage::OpenedPage(const viewer::Server& server, const PageOptions& options) {
  const std::vector<std::string> urls = server.urls();
  for (const std::string& url : urls) std::printf("viewer: %s\n", url.c_str());
  if (!server.fingerprint().empty()) {
    std::printf("viewer: certificate SHA-256 %s\n", server.fingerprint().c_str());
    LogWarning(
        "the viewer listens beyond this machine: whoever has the address may look and steer");
  }
  std::fflush(stdout);
  if (options.no_browser) return;
  file_ = WriteRedirect(urls.front());
  if (file_.empty() || !OpenInBrowser(file_)) LogInfo("open the address above in a browser");
}

OpenedPage::~OpenedPage() {
  std::error_code ignored;
  if (!file_.empty()) std::filesystem::remove(file_, ignored);
}

LiveView::LiveView(const PageOptions& options,
                   const std::string& title,
                   const viewer::FeedOptions& feed)
    : feed_(&log_, feed),
      server_(&log_,
              [&] {
                viewer::ServerOptions server = MakeServerOptions(options, title);
                server.controls = true;
                server.on_command = [this](viewer::Command command) { Obey(command); };
                return server;
              }()),
      page_(server_, options) {
  if (!options.wait) return;
  paused_ = true;
  feed_.SetState("waiting");
}

void LiveView::Obey(viewer::Command command) {
  switch (command) {
    case viewer::Command::kPause:
      paused_ = true;
      feed_.SetState("paused");
      break;
    case viewer::Command::kResume:
      paused_ = false;
      feed_.SetState("running");
      break;
    case viewer::Command::kFinish:
      finish_ = true;
      paused_ = false;
      feed_.SetState("finishing");
      break;
  }
}

void LiveView::WaitWhilePaused(bool (*cancelled)()) {
  while (paused_ && !finish_ && !cancelled()) std::this_thread::sleep_for(kPoll);
}

void LiveView::Linger(bool (*interrupted)()) {
  if (interrupted()) return;
  std::printf("viewer: stays open; end it with Ctrl-C\n");
  std::fflush(stdout);
  while (!interrupted()) std::this_thread::sleep_for(kPoll);
}

}  // namespace livemvs::app
