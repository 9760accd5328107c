#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "livemvs/io/dataset_text.h"

namespace livemvs {

/// What a legal file stays within; anything else is hostile or the wrong file.
struct JsonLimits {
  std::size_t max_bytes = kMaxTextBytes;
  int max_depth = 64;        ///< Of lists and objects within each other.
  bool unique_keys = false;  ///< A key of the whole file's object that stands there twice is wrong.
  std::string what;          ///< What the file should be, for messages: "transforms.json".
};

/// Reads a JSON file that nobody vouches for.
/// @throws Error (kBadInput) naming the file, and the key it was at.
nlohmann::json ReadJsonFile(const std::filesystem::path& file, const JsonLimits& limits);

}  // namespace livemvs
