#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace livemvs {

/// The square of bits inside of a marker's border, row-major from its upper left corner.
struct MarkerBits {
  int side = 0;                     ///< [bits]
  std::vector<std::uint8_t> white;  ///< 1: white. side * side of them.
};

/// Number of codes of a dictionary by OpenCV's name ("DICT_4X4_250"); 0: there is none of it.
int DictionarySize(const std::string& name);

/// For messages: "must be one of DICT_4X4_50, ...".
const char* KnownDictionaries();

/// The bits of a code.
/// @throws std::invalid_argument where the dictionary has no such code.
MarkerBits BitsOf(const std::string& dictionary, int id);

}  // namespace livemvs
