#pragma once

/// Little-endian numbers in byte strings. Private to stream/.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace livemvs {

using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;

template <std::size_t kSize>
struct UnsignedOfSize;
template <>
struct UnsignedOfSize<1> {
  using Type = std::uint8_t;
};
template <>
struct UnsignedOfSize<2> {
  using Type = std::uint16_t;
};
template <>
struct UnsignedOfSize<4> {
  using Type = std::uint32_t;
};
template <>
struct UnsignedOfSize<8> {
  using Type = std::uint64_t;
};

/// Appends numbers, least significant byte first, whatever the machine's order.
class ByteWriter {
 public:
  explicit ByteWriter(Bytes* out) : out_(out) {}

  template <typename T>
  void Put(T value) {
    const auto bits = std::bit_cast<typename UnsignedOfSize<sizeof(T)>::Type>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      out_->push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(bits) >> (8 * i)));
    }
  }

  /// Text: its length as uint32, then its bytes.
  void PutText(const std::string& text) {
    Put(static_cast<std::uint32_t>(text.size()));
    // Not insert(), in which GCC 12 sees a write beyond the end.
    for (const char c : text) out_->push_back(static_cast<std::uint8_t>(c));
  }

 private:
  Bytes* out_;
};

/// Takes numbers off the front of a byte string. Once one is missing, ok() is false for good and
/// numbers are 0.
class ByteReader {
 public:
  explicit ByteReader(ByteSpan bytes) : bytes_(bytes) {}

  template <typename T>
  T Get() {
    using Unsigned = typename UnsignedOfSize<sizeof(T)>::Type;
    if (bytes_.size() < sizeof(T)) {
      Fail();
      return T{};
    }
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) bits |= std::uint64_t{bytes_[i]} << (8 * i);
    bytes_ = bytes_.subspan(sizeof(T));
    return std::bit_cast<T>(static_cast<Unsigned>(bits));
  }

  std::string GetText() {
    const auto size = Get<std::uint32_t>();
    if (size > bytes_.size()) {
      Fail();
      return {};
    }
    std::string text(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size));
    bytes_ = bytes_.subspan(size);
    return text;
  }

  bool ok() const { return ok_; }
  std::size_t left() const { return bytes_.size(); }

 private:
  void Fail() {
    ok_ = false;
    bytes_ = {};
  }

  ByteSpan bytes_;
  bool ok_ = true;
};

}  // namespace livemvs
