#include "viewer/connection.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "livemvs/stream/messages.h"
#include "viewer/command.h"
#include "viewer/page.h"

namespace livemvs::viewer {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using std::chrono::seconds;

constexpr auto kRequestTime = seconds(10);
constexpr std::size_t kMaxHeaderBytes = 8192;
constexpr std::size_t kBatchBytes = std::size_t{256} << 10;
// Messages a second that a client may send, and so many at once.
constexpr double kCommandsPerSecond = 10;
constexpr double kCommandBurst = 20;

using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

std::string HelloJson(const ServerState& state) {
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

std::string CookieOf(const ServerState& state) {
  return state.rules.cookie_name + "=" + state.rules.token + "; Path=/; HttpOnly; SameSite=Strict" +
         (state.options.tls ? "; Secure" : "");
}

struct Answer {
  http::status status;
  std::string_view type = "text/plain; charset=utf-8";
  std::string_view body;
};

Answer AnswerTo(Verdict verdict, std::string_view path) {
  switch (verdict) {
    case Verdict::kPage:
      return {http::status::ok, FindAsset("/")->type, FindAsset("/")->bytes};
    case Verdict::kAsset:
      return {http::status::ok, FindAsset(path)->type, FindAsset(path)->bytes};
    case Verdict::kBadMethod:
      return {.status = http::status::method_not_allowed, .body = "GET and HEAD are understood.\n"};
    case Verdict::kForbidden:
      return {.status = http::status::forbidden,
              .body = "Open the address that livemvs printed: it holds the token of this run.\n"};
    case Verdict::kWrongHost:
      return {.status = http::status::misdirected_request,
              .body =
                  "This server is not known under that name. Open the address that livemvs "
                  "printed.\n"};
    case Verdict::kWrongOrigin:
      return {.status = http::status::forbidden, .body = "Other pages may not read this one.\n"};
    case Verdict::kStream:
    case Verdict::kNotFound:
      break;
  }
  return {.status = http::status::not_found, .body = "There is no such page.\n"};
}

template <typename Stream>
class HttpConnection : public std::enable_shared_from_this<HttpConnection<Stream>> {
 public:
  HttpConnection(Stream&& stream, std::shared_ptr<ServerState> state)
      : stream_(std::move(stream)), state_(std::move(state)) {
    ++state_->connections;
  }
  ~HttpConnection() { --state_->connections; }

  void Start() {
    beast::get_lowest_layer(stream_).expires_after(kRequestTime);
    if constexpr (std::is_same_v<Stream, TlsStream>) {
      stream_.async_handshake(asio::ssl::stream_base::server,
                              [self = this->shared_from_this()](error_code error) {
                                if (!error) self->Read();
                              });
    } else {
      Read();
    }
  }

 private:
  void Read() {
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(0);
    beast::get_lowest_layer(stream_).expires_after(kRequestTime);
    http::async_read(stream_,
                     buffer_,
                     *parser_,
                     [self = this->shared_from_this()](error_code error, std::size_t) {
                       if (!error) self->Respond();
                     });
  }

  void Respond() {
    const auto& request = parser_->get();
    const auto text = [](beast::string_view s) { return std::string_view(s.data(), s.size()); };
    RequestHead head{text(request.method_string()),
                     text(request.target()),
                     text(request[http::field::host]),
                     text(request[http::field::origin]),
                     text(request[http::field::cookie]),
                     websocket::is_upgrade(request)};
    const Verdict verdict = Judge(head, state_->rules);
    if (verdict == Verdict::kStream) {
      ++state_->connections;
      std::make_shared<WebSocketClient<Stream>>(std::move(stream_), state_)
          ->Accept(parser_->release());
      return;
    }
    const std::string_view path = head.target.substr(0, head.target.find('?'));
    const Answer answer = AnswerTo(verdict, path);
    if (answer.status != http::status::ok) {
      state_->count([](ServerStatistics* s) { ++s->refused; });
    }
    Write(answer, verdict == Verdict::kPage, head.method == "HEAD");
  }

  void Write(const Answer& answer, bool set_cookie, bool head_only) {
    response_ = {};
    response_.version(11);
    response_.result(answer.status);
    response_.set(http::field::content_type,
                  beast::string_view(answer.type.data(), answer.type.size()));
    response_.set(http::field::cache_control, "no-store");
    response_.set("Content-Security-Policy",
                  beast::string_view(kContentSecurityPolicy.data(), kContentSecurityPolicy.size()));
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Cross-Origin-Opener-Policy", "same-origin");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    if (set_cookie) response_.set(http::field::set_cookie, CookieOf(*state_));
    const bool keep = parser_->get().keep_alive() && answer.status == http::status::ok;
    response_.keep_alive(keep);
    response_.body() = {answer.body.data(), head_only ? 0 : answer.body.size()};
    response_.content_length(answer.body.size());
    beast::get_lowest_layer(stream_).expires_after(kRequestTime);
    http::async_write(
        stream_, response_, [self = this->shared_from_this(), keep](error_code error, std::size_t) {
          if (error) return;
          if (keep) return self->Read();
          error_code ignored;
          beast::get_lowest_layer(self->stream_)
              .socket()
              .shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
        });
  }

  Stream stream_;
  std::shared_ptr<ServerState> state_;
  beast::flat_buffer buffer_{kMaxHeaderBytes + 1024};
  std::optional<http::request_parser<http::empty_body>> parser_;
  http::response<http::span_body<const char>> response_;
};

}  // namespace

void ServePlain(asio::ip::tcp::socket socket, std::shared_ptr<ServerState> state) {
  std::make_shared<HttpConnection<PlainStream>>(PlainStream(std::move(socket)), std::move(state))
      ->Start();
}

void ServeTls(asio::ip::tcp::socket socket,
              asio::ssl::context* context,
              std::shared_ptr<ServerState> state) {
  std::make_shared<HttpConnection<TlsStream>>(TlsStream(std::move(socket), *context),
                                              std::move(state))
      ->Start();
}

}  // namespace livemvs::viewer
