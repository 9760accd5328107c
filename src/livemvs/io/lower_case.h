#pragma once

#include <cctype>
#include <filesystem>
#include <string>

namespace livemvs {

/// The text with A to Z as a to z: endings of file names are told apart without regard to case.
inline std::string LowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The ending of a file's name, as ".png".
inline std::string LowerExtension(const std::filesystem::path& path) {
  return LowerCase(path.extension().string());
}

}  // namespace livemvs
