#include "viewer/rules.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "livemvs/core/error.h"
#include "viewer/page.h"

namespace livemvs::viewer {
namespace {

bool Contains(const std::vector<std::string>& list, std::string_view text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

bool IsPlain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
}

std::string_view PathOf(std::string_view target) { return target.substr(0, target.find('?')); }

bool HasToken(const RequestHead& request, const AccessRules& rules) {
  const auto cookie = CookieValue(request.cookies, rules.cookie_name);
  return cookie && EqualInConstantTime(*cookie, rules.token);
}

}  // namespace

Verdict Judge(const RequestHead& request, const AccessRules& rules) {
  if (!Contains(rules.hosts, request.host)) return Verdict::kWrongHost;
  // Browsers send the Origin of whoever asks; for the stream it must be there.
  if ((request.upgrade || !request.origin.empty()) && !Contains(rules.origins, request.origin)) {
    return Verdict::kWrongOrigin;
  }
  if (request.method != "GET" && request.method != "HEAD") return Verdict::kBadMethod;
  const std::string_view path = PathOf(request.target);
  if (request.upgrade) {
    if (path != "/stream") return Verdict::kNotFound;
    return HasToken(request, rules) ? Verdict::kStream : Verdict::kForbidden;
  }
  if (path == "/") {
    const auto token = QueryParameter(request.target, "token");
    const bool allowed =
        token ? EqualInConstantTime(*token, rules.token) : HasToken(request, rules);
    return allowed ? Verdict::kPage : Verdict::kForbidden;
  }
  if (!HasToken(request, rules)) return Verdict::kForbidden;
  return FindAsset(path) != nullptr ? Verdict::kAsset : Verdict::kNotFound;
}

Resume ParseResume(std::string_view target) {
  Resume resume;
  const auto session = QueryParameter(target, "session");
  const auto from = QueryParameter(target, "from");
  if (!session || !from) return resume;
  std::uint32_t number = 0;
  const char* end = from->data() + from->size();
  const auto [parsed, error] = std::from_chars(from->data(), end, number);
  if (error != std::errc{} || parsed != end) return resume;
  resume.session = *session;
  resume.from = number;
  return resume;
}

std::optional<std::string> QueryParameter(std::string_view target, std::string_view name) {
  const auto question = target.find('?');
  if (question == std::string_view::npos) return std::nullopt;
  std::string_view query = target.substr(question + 1);
  std::optional<std::string> found;
  while (!query.empty()) {
    const auto end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    const auto equals = pair.find('=');
    if (equals == std::string_view::npos || pair.substr(0, equals) != name) continue;
    const std::string_view value = pair.substr(equals + 1);
    if (found || !IsPlain(value)) return std::nullopt;
    found = std::string(value);
  }
  return found;
}

std::optional<std::string> CookieValue(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    const auto end = std::min(cookies.find(';'), cookies.size());
    std::string_view pair = cookies.substr(0, end);
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    while (!pair.empty() && pair.front() == ' ') pair.remove_prefix(1);
    const auto equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name) {
      return std::string(pair.substr(equals + 1));
    }
  }
  return std::nullopt;
}

bool EqualInConstantTime(std::string_view a, std::string_view b) {
  // The length of a token is no secret.
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

std::string MakeToken() {
  std::array<unsigned char, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size())) {
    throw Error(ErrorKind::kFailed, "the viewer's token: the system gives no random numbers");
  }
  constexpr char kDigits[] = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bits) {
    token += kDigits[byte >> 4];
    token += kDigits[byte & 15];
  }
  return token;
}

}  // namespace livemvs::viewer
