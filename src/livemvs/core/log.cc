#include "livemvs/core/log.h"

#include <mutex>
#include <utility>

namespace livemvs {
namespace {

std::mutex log_mutex;

LogCallback& Callback() {
  static LogCallback callback;
  return callback;
}

void Log(LogLevel level, const std::string& message) {
  const std::lock_guard<std::mutex> lock(log_mutex);
  if (Callback()) Callback()(level, message);
}

}  // namespace

void SetLogCallback(LogCallback callback) {
  const std::lock_guard<std::mutex> lock(log_mutex);
  Callback() = std::move(callback);
}

void LogInfo(const std::string& message) { Log(LogLevel::kInfo, message); }

void LogWarning(const std::string& message) { Log(LogLevel::kWarning, message); }

}  // namespace livemvs
