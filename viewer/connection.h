#pragma once

/// One client, from its first byte on. Private to the server; everything runs on its one thread.

#include <utility>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "viewer/rules.h"
#include "viewer/server.h"

namespace livemvs::viewer {

/// A client that has the stream.
class StreamClient {
 public:
  virtual ~StreamClient() = default;
  virtual void Pump() = 0;  ///< Sends what is new, unless something is under way.
  virtual void Cut() = 0;   ///< Ends it, whatever it is doing.
};

/// What connections share.
struct ServerState {
  StreamLog* log = nullptr;
  ServerOptions options;
  AccessRules rules;
  std::set<StreamClient*> clients;
  int connections = 0;
  std::function<void(const std::function<void(ServerStatistics*)>&)> count;
};

/// Begins to serve a connection, which keeps itself alive.
void ServePlain(boost::asio::ip::tcp::socket socket, std::shared_ptr<ServerState> state);
void ServeTls(boost::asio::ip::tcp::socket socket,
              boost::asio::ssl::context* context,
              std::shared_ptr<ServerState> state);

}  // namespace livemvs::viewer
