#include "viewer/connection.h"

#include <optional>

#include "viewer/answer.h"
#include "viewer/page.h"
#include "viewer/stream_client.h"

namespace livemvs::viewer {
namespace {

constexpr std::size_t kMaxHeaderBytes = 8192;
using PlainStream = beast::tcp_stream;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

std::string CookieOf(const ServerState& state) {
  return state.rules.cookie_name + "=" + state.rules.token + "; Path=/; HttpOnly; SameSite=Strict" +
         (state.options.tls ? "; Secure" : "");
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
                  beast::string_view(answer.policy.data(), answer.policy.size()));
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
