#include "livemvs/io/json_file.h"

#include <set>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

using nlohmann::json;

// The library's words without its own number of the error.
std::string WordsOf(const json::exception& e) {
  constexpr std::size_t kLongest = 300;
  const std::string words = e.what();
  const std::size_t number = words.find("] ");
  return Shortened(number == std::string::npos ? words : words.substr(number + 2), kLongest);
}

}  // namespace

json ReadJsonFile(const std::filesystem::path& file, const JsonLimits& limits) {
  const std::string text = ReadTextFile(file, limits.max_bytes);
  std::string key;
  std::set<std::string> keys;
  const auto at_key = [&] { return key.empty() ? "" : " (at '" + Shortened(key) + "')"; };
  const auto look = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth > limits.max_depth) {
      throw BadInput(file.string() + ": nested deeper than " + std::to_string(limits.max_depth) +
                     " levels" + at_key() + "; this is no " + limits.what);
    }
    if (event != json::parse_event_t::key) return true;
    key = parsed.get<std::string>();
    if (limits.unique_keys && depth == 1 && !keys.insert(key).second) {
      throw BadInput(file.string() + ": '" + Shortened(key) + "' stands there twice");
    }
    return true;
  };
  try {
    return json::parse(text, look);
  } catch (const json::exception& e) {
    throw BadInput(file.string() + ": not valid JSON: " + WordsOf(e) + at_key());
  }
}

}  // namespace livemvs
