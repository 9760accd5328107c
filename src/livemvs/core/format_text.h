#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace livemvs {

/// As printf; what is longer than 299 characters is cut.
__attribute__((format(printf, 1, 2))) inline std::string FormatText(const char* format, ...) {
  char text[300];
  std::va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

}  // namespace livemvs
