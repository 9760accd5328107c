#include "viewer/server.h"

#include <arpa/inet.h>
#include <ifaddrs.h>

#include <atomic>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>

#include "livemvs/core/error.h"
#include "viewer/certificate.h"
#include "viewer/connection.h"

namespace livemvs::viewer {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

asio::ip::address ParseAddress(const std::string& text) {
  error_code error;
  const auto address = asio::ip::make_address(text, error);
  if (error || !address.is_v4()) {
    throw std::invalid_argument("--listen " + text + ": must be an IPv4 address");
  }
  return address;
}

// This machine's addresses, but for loopback ones.
std::vector<std::string> OwnAddresses() {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return addresses;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    const auto* in = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    char text[INET_ADDRSTRLEN];
    if (inet_ntop(AF_INET, &in->sin_addr, text, sizeof(text)) == nullptr) continue;
    if (std::string(text).rfind("127.", 0) != 0) addresses.emplace_back(text);
  }
  freeifaddrs(list);
  return addresses;
}

}  // namespace

void ServerOptions::Check() const {
  if (!ParseAddress(address).is_loopback() && !tls) {
    throw std::invalid_argument("--listen " + address + ": other machines may only come over TLS");
  }
  if (most_clients < 1) throw std::invalid_argument("most_clients: must be 1 or more");
  if (!(stall_seconds > 0)) throw std::invalid_argument("stall_seconds: must be above 0");
}

struct Server::Impl {
  Impl(StreamLog* log, const ServerOptions& options);
  void Listen();
  void AllowHosts();
  void AcceptNext();
  void Pump();
  void Cut();

  // Connections that are alive at the end go with `io`, and use what stands before it.
  mutable std::mutex mutex;
  ServerStatistics statistics;
  std::optional<asio::ssl::context> tls;
  std::shared_ptr<ServerState> state = std::make_shared<ServerState>();
  std::vector<std::string> addresses;  // under which it is reached, loopback first
  std::string fingerprint;
  std::atomic<bool> pump_pending{false};
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  std::thread thread;
};

Server::Impl::Impl(StreamLog* log, const ServerOptions& options) {
  state->log = log;
  state->options = options;
  state->rules.token = MakeToken();
  state->count = [this](const std::function<void(ServerStatistics*)>& change) {
    const std::scoped_lock lock(mutex);
    change(&statistics);
  };
  Listen();
  AllowHosts();
  if (options.tls) {
    std::vector<std::string> names = addresses;
    const Certificate certificate = MakeCertificate(names);
    fingerprint = certificate.fingerprint;
    tls.emplace(asio::ssl::context::tls_server);
    tls->set_options(asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1);
    tls->use_certificate_chain(asio::buffer(certificate.certificate));
    tls->use_private_key(asio::buffer(certificate.key), asio::ssl::context::pem);
  }
}

void Server::Impl::Listen() {
  const ServerOptions& options = state->options;
  const auto address = ParseAddress(options.address);
  acceptor.open(tcp::v4());
  acceptor.set_option(tcp::acceptor::reuse_address(true));
  error_code error;
  acceptor.bind({address, options.port}, error);
  if (error && options.port != 0 && !options.exact_port) {
    error = {};
    acceptor.bind({address, 0}, error);
  }
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    throw Error(ErrorKind::kFailed,
                "the viewer cannot listen at " + options.address + ":" +
                    std::to_string(options.port) + ": " + error.message() +
                    "; try another --listen or --port");
  }
}

// The names under which it answers: those that a browser of this machine, of the other end of a
// tunnel to the same port, or of the local network uses.
void Server::Impl::AllowHosts() {
  const ServerOptions& options = state->options;
  const auto address = ParseAddress(options.address);
  const std::string port = ":" + std::to_string(acceptor.local_endpoint().port());
  if (address.is_unspecified()) {
    addresses = OwnAddresses();
    addresses.insert(addresses.begin(), "127.0.0.1");
  } else {
    addresses = {options.address};
  }
  std::vector<std::string> names = addresses;
  names.emplace_back("localhost");
  for (const std::string& name : names) {
    state->rules.hosts.push_back(name + port);
    state->rules.origins.push_back((options.tls ? "https://" : "http://") + name + port);
  }
  state->rules.cookie_name = "livemvs_" + port.substr(1);
}

void Server::Impl::AcceptNext() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && state->connections < 4 * state->options.most_clients &&
        static_cast<int>(state->clients.size()) < state->options.most_clients) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      if (tls) {
        ServeTls(std::move(socket), &*tls, state);
      } else {
        ServePlain(std::move(socket), state);
      }
    }
    AcceptNext();
  });
}

void Server::Impl::Pump() {
  pump_pending = false;
  // A client that fails leaves the set.
  const std::vector<StreamClient*> clients(state->clients.begin(), state->clients.end());
  for (StreamClient* client : clients) {
    if (state->clients.contains(client)) client->Pump();
  }
}

void Server::Impl::Cut() {
  const std::vector<StreamClient*> clients(state->clients.begin(), state->clients.end());
  for (StreamClient* client : clients) client->Cut();
}

Server::Server(StreamLog* log, const ServerOptions& options) {
  options.Check();
  impl_ = std::make_unique<Impl>(log, options);
  impl_->AcceptNext();
  log->SetListener([impl = impl_.get()] {
    if (!impl->pump_pending.exchange(true)) asio::post(impl->io, [impl] { impl->Pump(); });
  });
  impl_->thread = std::thread([impl = impl_.get()] { impl->io.run(); });
}

Server::~Server() {
  impl_->state->log->SetListener({});
  asio::post(impl_->io, [impl = impl_.get()] {
    error_code ignored;
    impl->acceptor.close(ignored);
    impl->Cut();
    impl->io.stop();
  });
  impl_->thread.join();
}

std::vector<std::string> Server::urls() const {
  std::vector<std::string> urls;
  const bool tls = impl_->state->options.tls;
  for (const std::string& address : impl_->addresses) {
    urls.push_back((tls ? "https://" : "http://") + address + ":" + std::to_string(port()) +
                   "/?token=" + impl_->state->rules.token);
  }
  return urls;
}

std::uint16_t Server::port() const { return impl_->acceptor.local_endpoint().port(); }

std::string Server::fingerprint() const { return impl_->fingerprint; }

ServerStatistics Server::statistics() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->statistics;
}

void Server::CutClients() {
  asio::post(impl_->io, [impl = impl_.get()] { impl->Cut(); });
}

}  // namespace livemvs::viewer
