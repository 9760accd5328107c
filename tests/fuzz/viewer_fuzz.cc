// Hostile bytes for what the viewer's server reads: requests, resumptions and commands. The first
// byte chooses who gets the rest.

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "viewer/command.h"
#include "viewer/page.h"
#include "viewer/rules.h"

namespace {

using namespace livemvs::viewer;

void Require(bool condition) {
  if (!condition) std::abort();
}

const AccessRules kRules = {"0123456789abcdef0123456789abcdef",
                            {"127.0.0.1:7451"},
                            {"http://127.0.0.1:7451"},
                            "livemvs_7451"};

// Lines of the text become the parts of a request; nothing may get in without the token.
void FuzzRequest(std::string_view text) {
  std::string_view parts[5];
  for (std::string_view& part : parts) {
    const auto end = std::min(text.find('\n'), text.size());
    part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  RequestHead head{"GET", parts[0], parts[1], parts[2], parts[3], parts[4] == "upgrade"};
  const Verdict verdict = Judge(head, kRules);
  const bool token = parts[0].find(kRules.token) != std::string_view::npos ||
                     parts[3].find(kRules.token) != std::string_view::npos;
  if (verdict == Verdict::kPage || verdict == Verdict::kAsset || verdict == Verdict::kStream) {
    Require(token && parts[1] == "127.0.0.1:7451");
    Require(verdict != Verdict::kStream || parts[2] == "http://127.0.0.1:7451");
    const std::string_view path = parts[0].substr(0, parts[0].find('?'));
    Require(verdict == Verdict::kStream || FindAsset(path) != nullptr);
  }
  ParseResume(parts[0]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 3) {
    case 0:
      FuzzRequest(text);
      break;
    case 1:
      ParseCommand(text);
      break;
    default: {
      const Resume resume = ParseResume(text);
      for (const char c : resume.session)
        Require(std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_');
      CookieValue(text, "livemvs_7451");
      break;
    }
  }
  return 0;
}
