#pragma once

/// A client that has the stream, over TLS or not. Private to the server; see connection.h.

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "livemvs/stream/messages.h"
#include "viewer/command.h"
#include "viewer/connection.h"

namespace livemvs::viewer {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using std::chrono::seconds;

inline constexpr auto kRequestTime = seconds(10);
inline constexpr std::size_t kBatchBytes = std::size_t{256} << 10;
// Messages a second that a client may send, and so many at once.
inline constexpr double kCommandsPerSecond = 10;
inline constexpr double kCommandBurst = 20;

inline std::string HelloJson(const ServerState& state) {
  return nlohmann::json({{"session", state.log->session()},
                         {"title", state.options.title},
                         {"controls", state.options.controls}})
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

template <typename Stream>
class WebSocketClient : public StreamClient,
                        public std::enable_shared_from_this<WebSocketClient<Stream>> {
 public:
  WebSocketClient(Stream&& stream, std::shared_ptr<ServerState> state)
      : socket_(std::move(stream)), stall_(socket_.get_executor()), state_(std::move(state)) {}
  ~WebSocketClient() override {
    state_->clients.erase(this);
    --state_->connections;
    const auto clients = static_cast<int>(state_->clients.size());
    state_->count([clients](ServerStatistics* s) { s->clients = clients; });
  }

  void Accept(http::request<http::empty_body> request) {
    request_ = std::move(request);
    const std::string_view target(request_.target().data(), request_.target().size());
    const Resume resume = ParseResume(target);
    if (resume.session == state_->log->session() && resume.from <= state_->log->size()) {
      cursor_.next = resume.from;
    }
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout{kRequestTime, seconds(60), true});
    socket_.read_message_max(kMaxCommandBytes);
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.async_accept(request_, [self = this->shared_from_this()](error_code error) {
      if (!error) self->Start();
    });
  }

  void Pump() override {
    if (writing_ || !open_) return;
    std::vector<SharedBytes> batch;
    batch.swap(greeting_);
    if (batch.empty()) batch = state_->log->Take(&cursor_, kBatchBytes);
    if (!batch.empty()) Send(std::move(batch));
  }

  void Cut() override {
    open_ = false;
    stall_.cancel();
    beast::get_lowest_layer(socket_).close();
  }

 private:
  void Start() {
    open_ = true;
    state_->clients.insert(this);
    const auto clients = static_cast<int>(state_->clients.size());
    state_->count([clients](ServerStatistics* s) {
      s->clients = clients;
      ++s->accepted;
    });
    greeting_.push_back(MakeUnnumbered(kRecordHello, EncodeStatistics(HelloJson(*state_))));
    Read();
    Pump();
  }

  void Send(std::vector<SharedBytes> batch) {
    writing_ = true;
    std::vector<asio::const_buffer> buffers;
    std::size_t bytes = 0;
    for (const SharedBytes& record : batch) {
      buffers.emplace_back(record->data(), record->size());
      bytes += record->size();
    }
    stall_.expires_after(std::chrono::duration_cast<std::chrono::milliseconds>(
        std::chrono::duration<double>(state_->options.stall_seconds)));
    stall_.async_wait([weak = this->weak_from_this()](error_code error) {
      if (const auto self = weak.lock(); self && !error) self->DropStalled();
    });
    socket_.async_write(buffers,
                        [self = this->shared_from_this(), batch = std::move(batch), bytes](
                            error_code error, std::size_t) {
                          self->writing_ = false;
                          self->stall_.cancel();
                          self->state_->count([bytes](ServerStatistics* s) {
                            s->bytes_sent += static_cast<std::int64_t>(bytes);
                          });
                          if (error) return self->Cut();
                          self->Pump();
                        });
  }

  void DropStalled() {
    state_->count([](ServerStatistics* s) { ++s->dropped_stalled; });
    Cut();
  }

  void Read() {
    socket_.async_read(incoming_, [self = this->shared_from_this()](error_code error, std::size_t) {
      if (error) return self->Cut();
      self->Obey();
    });
  }

  void Obey() {
    const auto data = incoming_.data();
    const auto command = ParseCommand(
        {static_cast<const char*>(data.data()), static_cast<std::size_t>(data.size())});
    incoming_.consume(incoming_.size());
    if (!MayAskAgain() || !command) return Cut();
    if (state_->options.controls && state_->options.on_command) {
      state_->options.on_command(*command);
    }
    Read();
  }

  // A bucket that fills at a steady rate.
  bool MayAskAgain() {
    const auto now = std::chrono::steady_clock::now();
    const double elapsed = std::chrono::duration<double>(now - asked_).count();
    asked_ = now;
    allowance_ = std::min(kCommandBurst, allowance_ + elapsed * kCommandsPerSecond) - 1;
    return allowance_ >= 0;
  }

  websocket::stream<Stream> socket_;
  asio::steady_timer stall_;
  std::shared_ptr<ServerState> state_;
  http::request<http::empty_body> request_;
  beast::flat_static_buffer<kMaxCommandBytes> incoming_;
  std::vector<SharedBytes> greeting_;
  StreamLog::Cursor cursor_;
  std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
  double allowance_ = kCommandBurst;
  bool open_ = false;
  bool writing_ = false;
};

}  // namespace livemvs::viewer
