#pragma once

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <type_traits>

namespace livemvs::experiments {

/// Writes a table: a line of column names, then rows.
class Csv {
 public:
  /// @param header  Column names with their units, separated by commas.
  /// @throws Error where the file cannot be made.
  Csv(const std::filesystem::path& path, const std::string& header);

  /// Text and numbers; numbers with five significant digits, which also keeps tables that are made
  /// again on another machine comparable.
  template <typename... T>
  void Row(const T&... values) {
    std::string line;
    (Append(&line, values), ...);
    line.back() = '\n';
    Write(line);
  }

 private:
  template <typename T>
  static void Append(std::string* line, const T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      char text[32];
      if constexpr (std::is_integral_v<T>) {
        std::snprintf(text, sizeof(text), "%lld", static_cast<long long>(value));
      } else {
        std::snprintf(text, sizeof(text), "%.5g", static_cast<double>(value));
      }
      *line += text;
    } else {
      *line += value;
    }
    *line += ',';
  }
  void Write(const std::string& line);

  std::filesystem::path path_;
  std::ofstream file_;
};

}  // namespace livemvs::experiments
