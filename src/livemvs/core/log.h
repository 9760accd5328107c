#pragma once

#include <functional>
#include <string>

namespace livemvs {

enum class LogLevel { kInfo, kWarning };

/// Receives every message of the library, one line without a line end. May be called from any
/// thread.
using LogCallback = std::function<void(LogLevel, const std::string&)>;

/// Installs the process-wide callback; an empty one drops messages (the default). The library never
/// prints by itself.
void SetLogCallback(LogCallback callback);

void LogInfo(const std::string& message);
void LogWarning(const std::string& message);

}  // namespace livemvs
