#pragma once

/// The bytes of a PLY file and its header. Private to io/.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "livemvs/core/error.h"

namespace livemvs::ply {

/// Reads a file from front to back, unpacked where it is compressed by gzip.
class ByteStream {
 public:
  /// @throws Error (kBadInput) where the file is missing, empty or unreadable.
  ByteStream(const std::filesystem::path& path, std::int64_t max_unpacked_bytes);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  /// Reads exactly `size` bytes.
  /// @throws Error (kBadInput) where the file ends before.
  void Read(void* data, std::size_t size);

  /// Passes over `size` bytes. @throws Error (kBadInput) where the file ends before.
  void Skip(std::int64_t size);

  /// The next byte, or -1 at the end.
  int Get();

  /// The next line without its end. @throws Error (kBadInput) where it is longer than 4096 bytes,
  /// or at the end of the file.
  std::string Line();

  /// The next word between white space. @throws Error (kBadInput) where it is longer than 100
  /// bytes, or at the end of the file.
  std::string_view Word();

  /// At most so many bytes can follow; a bound, where the file is compressed.
  std::int64_t MostBytesLeft() const { return most_bytes_ - consumed_; }

  /// An error that names the file and, as its place, the number of the byte reached.
  Error Damaged(const std::string& what) const;

 private:
  bool Fill();

  std::filesystem::path path_;
  void* file_ = nullptr;  ///< A gzFile, which reads plain files too.
  std::int64_t most_bytes_ = 0;
  std::int64_t consumed_ = 0;
  std::vector<unsigned char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::string word_;
};

enum class Format { kAscii, kLittleEndian, kBigEndian };
enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

int SizeOf(Type type);
inline bool IsFloat(Type type) { return type == Type::kFloat32 || type == Type::kFloat64; }

struct Property {
  std::string name;
  Type type = Type::kFloat32;
  bool is_list = false;
  Type count_type = Type::kUint8;  ///< Of a list.
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::vector<std::string> comments;
};

/// Reads the header and checks that the rows it promises can be in the file.
/// @throws Error (kBadInput) naming the line.
Header ReadHeader(ByteStream& in);

/// The next number of a body, in ascii or binary.
double ReadNumber(ByteStream& in, Format format, Type type);

}  // namespace livemvs::ply
