#pragma once

/// What the server lets in and answers, as pure functions: nothing here touches a socket.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace livemvs::viewer {

/// Who may talk to the server.
struct AccessRules {
  std::string token;                 ///< Hexadecimal; 128 bits.
  std::vector<std::string> hosts;    ///< Exact values of the Host header: "127.0.0.1:7451".
  std::vector<std::string> origins;  ///< Exact values of Origin: "http://127.0.0.1:7451".
  std::string cookie_name;           ///< Cookies are shared by all ports of a host.
};

/// A request as far as the rules look at it.
struct RequestHead {
  std::string_view method;
  std::string_view target;  ///< "/path?query", as sent.
  std::string_view host;
  std::string_view origin;  ///< Empty: not sent.
  std::string_view cookies;
  bool upgrade = false;  ///< Asks for a WebSocket.
};

enum class Verdict {
  kPage,         ///< The page itself, with the cookie that lets the rest in.
  kAsset,        ///< Another file of the page.
  kStream,       ///< The WebSocket.
  kNotFound,     ///< 404
  kBadMethod,    ///< 405
  kForbidden,    ///< 403: no token, or a wrong one.
  kWrongHost,    ///< 421: a name that is not ours, as in DNS rebinding.
  kWrongOrigin,  ///< 403: a page of somebody else's.
};

/// Judges a request. Host and Origin are compared whole, tokens in constant time.
Verdict Judge(const RequestHead& request, const AccessRules& rules);

/// Where the client's stream ended, for kStream: "/stream?session=…&from=…".
struct Resume {
  std::string session;
  std::uint32_t from = 0;
};
Resume ParseResume(std::string_view target);

/// The value of a query's parameter, where it is there once and has nothing but letters, digits,
/// - and _.
std::optional<std::string> QueryParameter(std::string_view target, std::string_view name);

/// The value of a cookie, or nothing.
std::optional<std::string> CookieValue(std::string_view cookies, std::string_view name);

/// Equality in a time that does not depend on where two texts differ.
bool EqualInConstantTime(std::string_view a, std::string_view b);

/// 128 random bits from the system, in hexadecimal. @throws Error where there are none.
std::string MakeToken();

}  // namespace livemvs::viewer
