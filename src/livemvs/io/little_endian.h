#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace livemvs {

/// Appends a number to bytes, the least significant byte first.
template <typename T>
void AppendLittleEndian(std::string* bytes, T value) {
  static_assert(std::is_arithmetic_v<T>);
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(raw);
  bytes->append(raw.data(), raw.size());
}

/// The number that starts at `bytes`, the least significant byte first.
template <typename T>
T FromLittleEndian(const char* bytes) {
  static_assert(std::is_arithmetic_v<T>);
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(raw);
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return value;
}

}  // namespace livemvs
