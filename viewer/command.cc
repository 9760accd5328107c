#include "viewer/command.h"

#include <nlohmann/json.hpp>
#include <string>

namespace livemvs::viewer {

std::optional<Command> ParseCommand(std::string_view text) {
  if (text.size() > kMaxCommandBytes) return std::nullopt;
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || json.size() != 1 || !json.contains("do") || !json["do"].is_string()) {
    return std::nullopt;
  }
  const auto& verb = json["do"].get_ref<const std::string&>();
  if (verb == "pause") return Command::kPause;
  if (verb == "resume") return Command::kResume;
  if (verb == "finish") return Command::kFinish;
  return std::nullopt;
}

}  // namespace livemvs::viewer
