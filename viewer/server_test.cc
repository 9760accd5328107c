#include "viewer/server.h"

#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/sha.h>

#include <utility>

#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <thread>

#include "livemvs/core/error.h"
#include "livemvs/stream/messages.h"

namespace livemvs::viewer {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

ServerOptions TestOptions() {
  ServerOptions options;
  options.port = 0;
  options.controls = true;
  return options;
}

std::string TokenOf(const Server& server) {
  const std::string url = server.urls().front();
  return url.substr(url.find("token=") + 6);
}

std::string HostOf(const Server& server) { return "127.0.0.1:" + std::to_string(server.port()); }

std::string CookieOf(const Server& server) {
  return "livemvs_" + std::to_string(server.port()) + "=" + TokenOf(server);
}

tcp::socket Connect(asio::io_context& io, std::uint16_t port) {
  tcp::socket socket(io);
  socket.connect({asio::ip::make_address("127.0.0.1"), port});
  return socket;
}

http::response<http::string_body> Fetch(const Server& server,
                                        const std::string& target,
                                        const std::string& host,
                                        const std::string& cookie = "",
                                        http::verb verb = http::verb::get) {
  asio::io_context io;
  tcp::socket socket = Connect(io, server.port());
  http::request<http::empty_body> request{verb, target, 11};
  request.set(http::field::host, host);
  if (!cookie.empty()) request.set(http::field::cookie, cookie);
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  error_code error;
  http::read(socket, buffer, response, error);
  return response;
}

/// A client of the stream.
class Client {
 public:
  Client(const Server& server,
         const std::string& origin,
         const std::string& cookie,
         const std::string& target = "/stream")
      : socket_(Connect(io_, server.port())) {
    socket_.set_option(websocket::stream_base::decorator([=](websocket::request_type& request) {
      request.set(http::field::origin, origin);
      request.set(http::field::cookie, cookie);
    }));
    socket_.handshake(response_, HostOf(server), target, error_);
    socket_.binary(true);
  }
  explicit Client(const Server& server, const std::string& target = "/stream")
      : Client(server, "http://" + HostOf(server), CookieOf(server), target) {}

  bool open() const { return !error_; }

  /// Reads until `records` numbered ones came; false where the server closes before.
  bool Read(std::size_t records) {
    while (numbers_.size() < records) {
      beast::flat_buffer buffer;
      socket_.read(buffer, error_);
      if (error_) return false;
      const auto data = buffer.cdata();
      std::span<const std::uint8_t> bytes(static_cast<const std::uint8_t*>(data.data()),
                                          data.size());
      bytes_ += bytes.size();
      while (!bytes.empty()) {
        const ParseResult result = ParseRecord(bytes);
        if (result.status != ParseStatus::kRecord) return false;
        if (result.record.sequence != kUnnumbered) numbers_.push_back(result.record.sequence);
        if (result.record.type == kRecordHello) hello_ = *DecodeStatistics(result.record.payload);
        bytes = bytes.subspan(result.bytes_used);
      }
    }
    return true;
  }

  void Say(const std::string& text) {
    error_code ignored;
    socket_.write(asio::buffer(text), ignored);
  }

  /// True once the server has closed.
  bool Closes() {
    while (!error_) {
      beast::flat_buffer buffer;
      socket_.read(buffer, error_);
    }
    return true;
  }

  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  const std::string& hello() const { return hello_; }
  std::size_t bytes() const { return bytes_; }

 private:
  asio::io_context io_;
  websocket::stream<tcp::socket> socket_;
  websocket::response_type response_;
  error_code error_;
  std::vector<std::uint32_t> numbers_;
  std::string hello_;
  std::size_t bytes_ = 0;
};

void Fill(StreamLog* log, int records, std::size_t size = 64) {
  const std::vector<std::uint8_t> payload(size, 5);
  for (int i = 0; i < records; ++i) log->Append(RecordType::kMessage, payload);
}

template <typename F>
bool Eventually(F&& condition, double seconds = 10) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (Clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

TEST(Server, ServesThePageToWhoHasTheToken) {
  StreamLog log;
  const Server server(&log, TestOptions());
  const auto page = Fetch(server, "/?token=" + TokenOf(server), HostOf(server));
  EXPECT_EQ(page.result_int(), 200U);
  EXPECT_NE(page.body().find("<title>livemvs</title>"), std::string::npos);
  const std::string cookie(page[http::field::set_cookie]);
  EXPECT_EQ(cookie.rfind(CookieOf(server) + ";", 0), 0U);
  EXPECT_NE(cookie.find("HttpOnly"), std::string::npos);
  EXPECT_NE(cookie.find("SameSite=Strict"), std::string::npos);
  EXPECT_NE(std::string(page["Content-Security-Policy"]).find("default-src 'none'"),
            std::string::npos);
  EXPECT_EQ(page["X-Content-Type-Options"], "nosniff");
  EXPECT_EQ(page[http::field::access_control_allow_origin], "");
  const auto script = Fetch(server, "/app.js", HostOf(server), CookieOf(server));
  EXPECT_EQ(script.result_int(), 200U);
  EXPECT_GT(script.body().size(), 1000U);
}

TEST(Server, RefusesWhoHasNot) {
  StreamLog log;
  const Server server(&log, TestOptions());
  const std::string host = HostOf(server);
  EXPECT_EQ(Fetch(server, "/", host).result_int(), 403U);
  EXPECT_EQ(Fetch(server, "/?token=00", host).result_int(), 403U);
  EXPECT_EQ(Fetch(server, "/app.js", host).result_int(), 403U);
  EXPECT_EQ(Fetch(server, "/", "evil.example", CookieOf(server)).result_int(), 421U);
  EXPECT_EQ(Fetch(server, "/../../etc/passwd", host, CookieOf(server)).result_int(), 404U);
  EXPECT_EQ(Fetch(server, "/", host, CookieOf(server), http::verb::post).result_int(), 405U);
  EXPECT_FALSE(Client(server, "http://evil.example", CookieOf(server)).open());
  EXPECT_FALSE(Client(server, "", CookieOf(server)).open());
  EXPECT_FALSE(Client(server, "http://" + host, "").open());
  EXPECT_EQ(server.statistics().accepted, 0);
  EXPECT_EQ(server.statistics().refused, 9);
}

// The policy lets in the style of that page alone, by its hash.
TEST(Server, ThePageThatRefusesSaysWhatToDoAndMayBeStyled) {
  StreamLog log;
  const Server server(&log, TestOptions());
  const auto page = Fetch(server, "/?token=00", HostOf(server));
  EXPECT_EQ(page[http::field::content_type], "text/html; charset=utf-8");
  EXPECT_NE(page.body().find("Open the address that livemvs printed"), std::string::npos);
  const std::size_t begin = page.body().find("<style>") + 7;
  const std::string style = page.body().substr(begin, page.body().find("</style>") - begin);
  ASSERT_GT(style.size(), 100U);
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(style.data()), style.size(), digest.data());
  std::array<unsigned char, 64> base64{};
  EVP_EncodeBlock(base64.data(), digest.data(), static_cast<int>(digest.size()));
  const std::string hash = reinterpret_cast<const char*>(base64.data());
  const std::string policy(page["Content-Security-Policy"]);
  EXPECT_NE(policy.find("style-src 'sha256-" + hash + "';"), std::string::npos)
      << "kRefusalPolicy must name " << hash;
  EXPECT_EQ(policy.find("default-src 'none'"), 0U);
  EXPECT_EQ(policy.find("script"), std::string::npos);
}

TEST(Server, AbsurdRequestsEndTheConnectionAlone) {
  StreamLog log;
  const Server server(&log, TestOptions());
  for (const std::string& bytes :
       {std::string("\r\n\r\n\0\xff garbage \r\n\r\n", 18),
        "GET / HTTP/1.1\r\nHost: " + std::string(100000, 'x'),
        "GET " + std::string(100000, '/') + " HTTP/1.1\r\n\r\n",
        std::string("GET / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n")}) {
    asio::io_context io;
    tcp::socket socket = Connect(io, server.port());
    error_code error;
    asio::write(socket, asio::buffer(bytes), error);
    char answer[4096];
    while (!error) socket.read_some(asio::buffer(answer), error);
  }
  EXPECT_EQ(Fetch(server, "/", HostOf(server), CookieOf(server)).result_int(), 200U);
}

TEST(Server, StreamsToSeveralClientsFromTheStartOrWhereTheyWere) {
  StreamLog log;
  ServerOptions options = TestOptions();
  options.title = "a \"title\"";
  const Server server(&log, options);
  Fill(&log, 100);
  Client a(server), b(server);
  ASSERT_TRUE(a.Read(100));
  EXPECT_NE(a.hello().find(log.session()), std::string::npos);
  EXPECT_NE(a.hello().find(R"("title":"a \"title\"")"), std::string::npos);
  Fill(&log, 50);
  ASSERT_TRUE(a.Read(150));
  ASSERT_TRUE(b.Read(150));
  EXPECT_EQ(a.numbers(), b.numbers());
  for (std::uint32_t i = 0; i < 150; ++i) EXPECT_EQ(a.numbers()[i], i);
  Client resumed(server, "/stream?session=" + log.session() + "&from=120");
  ASSERT_TRUE(resumed.Read(30));
  EXPECT_EQ(resumed.numbers().front(), 120U);
  Client stranger(server, "/stream?session=0123&from=120");
  ASSERT_TRUE(stranger.Read(150));
  EXPECT_EQ(stranger.numbers().front(), 0U);
  EXPECT_EQ(server.statistics().clients, 4);
}

TEST(Server, CutClientsComeBack) {
  StreamLog log;
  Server server(&log, TestOptions());
  Fill(&log, 10);
  Client client(server);
  ASSERT_TRUE(client.Read(10));
  server.CutClients();
  EXPECT_TRUE(client.Closes());
  Fill(&log, 10);
  Client again(server, "/stream?session=" + log.session() + "&from=10");
  ASSERT_TRUE(again.Read(10));
  EXPECT_EQ(again.numbers().back(), 19U);
}

TEST(Server, ObeysCommandsAndNothingElse) {
  StreamLog log;
  std::atomic<int> paused{0}, finished{0};
  ServerOptions options = TestOptions();
  options.on_command = [&](Command command) {
    paused += command == Command::kPause ? 1 : 0;
    finished += command == Command::kFinish ? 1 : 0;
  };
  const Server server(&log, options);
  Client client(server);
  client.Say(R"({"do":"pause"})");
  client.Say(R"({"do":"finish"})");
  EXPECT_TRUE(Eventually([&] { return paused == 1 && finished == 1; }));
  client.Say(R"({"do":"save","path":"/etc/passwd"})");
  EXPECT_TRUE(client.Closes());
  Client large(server);
  large.Say(std::string(5000, ' '));
  EXPECT_TRUE(large.Closes());
  Client flood(server);
  for (int i = 0; i < 100; ++i) flood.Say(R"({"do":"pause"})");
  EXPECT_TRUE(flood.Closes());
  EXPECT_LT(paused, 50);
}

// Who stops reading costs the others nothing, and is dropped.
TEST(Server, AStalledClientIsDroppedAndHoldsNobodyUp) {
  StreamLog log;
  ServerOptions options = TestOptions();
  options.stall_seconds = 1;
  const Server server(&log, options);
  Client stalled(server);
  Client reader(server);
  ASSERT_TRUE(Eventually([&] { return server.statistics().clients == 2; }));
  double slowest = 0;
  constexpr int kRecords = 600;
  std::thread reading([&] { EXPECT_TRUE(reader.Read(kRecords)); });
  const std::vector<std::uint8_t> payload(100'000, 7);
  for (int i = 0; i < kRecords; ++i) {
    const auto start = Clock::now();
    log.Append(RecordType::kMessage, payload);
    slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - start).count());
  }
  reading.join();
  EXPECT_EQ(reader.numbers().size(), static_cast<std::size_t>(kRecords));
  EXPECT_LT(slowest, 0.5);
  EXPECT_TRUE(Eventually([&] { return server.statistics().dropped_stalled == 1; }));
  EXPECT_EQ(server.statistics().clients, 1);
}

TEST(Server, TakesNoMoreClientsThanItMay) {
  StreamLog log;
  ServerOptions options = TestOptions();
  options.most_clients = 2;
  const Server server(&log, options);
  Client a(server), b(server);
  ASSERT_TRUE(a.open() && b.open());
  ASSERT_TRUE(Eventually([&] { return server.statistics().clients == 2; }));
  EXPECT_FALSE(Client(server).open());
}

TEST(Server, OtherMachinesComeOverTlsAlone) {
  StreamLog log;
  ServerOptions options = TestOptions();
  options.address = "0.0.0.0";
  EXPECT_THROW(Server(&log, options), std::invalid_argument);
  options.address = "127.0.0.1x";
  EXPECT_THROW(Server(&log, options), std::invalid_argument);
  options = TestOptions();
  options.tls = true;
  const Server server(&log, options);
  EXPECT_EQ(server.urls().front().rfind("https://127.0.0.1:", 0), 0U);
  asio::io_context io;
  asio::ssl::context context(asio::ssl::context::tls_client);
  beast::ssl_stream<tcp::socket> stream(Connect(io, server.port()), context);
  stream.handshake(asio::ssl::stream_base::client);
  X509* certificate = SSL_get1_peer_certificate(stream.native_handle());
  ASSERT_NE(certificate, nullptr);
  EXPECT_EQ(X509_check_ip_asc(certificate, "127.0.0.1", 0), 1);
  unsigned char digest[32];
  unsigned size = 0;
  X509_digest(certificate, EVP_sha256(), digest, &size);
  X509_free(certificate);
  char first[4];
  std::snprintf(first, sizeof(first), "%02X:", digest[0]);
  EXPECT_EQ(server.fingerprint().substr(0, 3), first);
  EXPECT_EQ(server.fingerprint().size(), 95U);
  http::request<http::empty_body> request{http::verb::get, "/?token=" + TokenOf(server), 11};
  request.set(http::field::host, HostOf(server));
  http::write(stream, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  http::read(stream, buffer, response);
  EXPECT_EQ(response.result_int(), 200U);
  EXPECT_NE(std::string(response[http::field::set_cookie]).find("Secure"), std::string::npos);
  // Without TLS there is no answer.
  EXPECT_EQ(Fetch(server, "/", HostOf(server)).body(), "");
}

TEST(Server, TakesAnotherPortWhereItMay) {
  StreamLog log;
  const Server first(&log, TestOptions());
  ServerOptions options = TestOptions();
  options.port = first.port();
  StreamLog other;
  const Server second(&other, options);
  EXPECT_NE(second.port(), first.port());
  options.exact_port = true;
  EXPECT_THROW(Server(&other, options), Error);
}

TEST(Server, EndsWithClientsAtWork) {
  StreamLog log;
  std::unique_ptr<Client> client;
  {
    const Server server(&log, TestOptions());
    client = std::make_unique<Client>(server);
    Fill(&log, 100, 100'000);
  }
  EXPECT_TRUE(client->Closes());
  Fill(&log, 1);  // nobody listens any more
}

}  // namespace
}  // namespace livemvs::viewer
