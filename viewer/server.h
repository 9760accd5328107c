#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "viewer/command.h"
#include "viewer/stream_log.h"

namespace livemvs::viewer {

struct ServerOptions {
  /// Where to listen. Other machines reach it only where this is not a loopback address, and then
  /// only over TLS.
  std::string address = "127.0.0.1";
  /// 0: any free port. Another that is taken is replaced by a free one unless `exact_port`.
  std::uint16_t port = 7451;
  bool exact_port = false;
  bool tls = false;
  int most_clients = 16;
  /// A client that takes none of what it was sent for so long is dropped [s].
  double stall_seconds = 20;
  /// For the page: what it shows, and whether there is something to pause and finish.
  std::string title;
  bool controls = false;
  /// Called from the server's thread with what clients ask for; must be quick. May be empty.
  std::function<void(Command)> on_command;

  void Check() const;  ///< @throws std::invalid_argument naming the field.
};

struct ServerStatistics {
  int clients = 0;                   ///< That have the stream at the moment.
  std::int64_t accepted = 0;         ///< Streams that began.
  std::int64_t refused = 0;          ///< Requests for want of token, host or origin.
  std::int64_t dropped_stalled = 0;  ///< Clients that stopped reading.
  std::int64_t bytes_sent = 0;
};

/// Serves the page and the stream on a thread of its own. Nothing that a client does makes the
/// writer of the log wait.
class Server {
 public:
  /// Listens when it returns.
  /// @param log  Must outlive the server.
  /// @throws Error (kFailed) where it cannot listen; std::invalid_argument for options that are
  /// wrong, such as another machine's access without TLS.
  Server(StreamLog* log, const ServerOptions& options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// What to open in a browser: it holds the token, and is nobody else's business. The first is for
  /// this machine; where others may come, their addresses follow.
  std::vector<std::string> urls() const;
  std::uint16_t port() const;
  /// Of the certificate, for comparison with what a browser shows; empty without TLS.
  std::string fingerprint() const;
  ServerStatistics statistics() const;

  /// Cuts all clients off, as a failing network would. For tests.
  void CutClients();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livemvs::viewer
