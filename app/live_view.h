#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "livemvs/core/options.h"
#include "viewer/feed.h"
#include "viewer/server.h"

namespace livemvs::app {

struct PageOptions {
  bool view = false;
  bool no_browser = false;
  bool wait = false;  ///< At the first frame, until the page says start.
  std::string listen = "127.0.0.1";
  std::uint16_t port = 7451;
};

/// Adds --view and its companions to a command that reconstructs; without `with_flag`, those of a
/// command that shows in any case.
void AddPageOptions(CLI::App* command, PageOptions* options, bool with_flag = true);

/// Makes a server's options of a command's.
viewer::ServerOptions MakeServerOptions(const PageOptions& options, const std::string& title);

/// Prints the server's addresses, and opens the first in a browser unless that is unwanted. The
/// token reaches the browser in a private file, not among the arguments that others can list.
class OpenedPage {
 public:
  OpenedPage(const viewer::Server& server, const PageOptions& options);
  ~OpenedPage();
  OpenedPage(const OpenedPage&) = delete;
  OpenedPage& operator=(const OpenedPage&) = delete;

 private:
  std::filesystem::path file_;
};

/// The live viewer beside a reconstruction: the stream, its server, and what the page asks for.
class LiveView {
 public:
  LiveView(const PageOptions& options, const std::string& title, const viewer::FeedOptions& feed);

  viewer::Feed& feed() { return feed_; }
  viewer::StreamLog& log() { return log_; }
  /// Waits while the page says pause, unless `cancelled`.
  void WaitWhilePaused(bool (*cancelled)());
  bool finish_asked() const { return finish_; }
  /// Keeps serving until a signal comes.
  void Linger(bool (*interrupted)());

 private:
  void Obey(viewer::Command command);

  std::atomic<bool> paused_{false};
  std::atomic<bool> finish_{false};
  viewer::StreamLog log_;
  viewer::Feed feed_;
  viewer::Server server_;
  OpenedPage page_;
};

}  // namespace livemvs::app
