#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace livemvs::viewer {

/// What a client may ask for. There is no argument that could name a file or a number.
enum class Command { kPause, kResume, kFinish };

/// Longer messages are refused before they are read. [bytes]
inline constexpr std::size_t kMaxCommandBytes = 256;

/// A client's message: {"do": "pause"}. Nothing where it is anything else.
std::optional<Command> ParseCommand(std::string_view text);

}  // namespace livemvs::viewer
