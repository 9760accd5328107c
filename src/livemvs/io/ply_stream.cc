#include "livemvs/io/ply_stream.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <system_error>

namespace livemvs::ply {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferSize = 1 << 18;
constexpr std::size_t kMaxLine = 4096;
constexpr std::size_t kMaxWord = 100;
/// Deflate makes at most so many bytes of one.
constexpr std::int64_t kMaxInflation = 1032;

template <typename T>
double FromBytes(const unsigned char* bytes, bool swap) {
  unsigned char ordered[sizeof(T)];
  std::memcpy(ordered, bytes, sizeof(T));
  if (swap) std::reverse(ordered, ordered + sizeof(T));
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return static_cast<double>(value);
}

double ParseWord(ByteStream& in) {
  std::string_view word = in.Word();
  if (word.size() > 1 && word[0] == '+') word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) {  // 1e-400 or 1e400
    const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
    return tiny ? 0 : std::numeric_limits<double>::infinity();
  }
  if (error != std::errc() || end != word.data() + word.size()) {
    throw in.Damaged("'" + std::string(word) + "' is not a number");
  }
  return value;
}

}  // namespace

ByteStream::ByteStream(const fs::path& path, std::int64_t max_unpacked_bytes) : path_(path) {
  const std::string name = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw BadInput(name + ": there is no such file");
  if (!fs::is_regular_file(status)) throw BadInput(name + ": is not an ordinary file");
  const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
  if (error || size == 0) throw BadInput(name + ": is empty (0 bytes)");
  buffer_.resize(kBufferSize);
  const gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) {
    throw BadInput(name + ": cannot be opened for reading; check its permissions");
  }
  file_ = file;
  gzbuffer(file, kBufferSize);
  if (gzdirect(file)) {
    most_bytes_ = size;
  } else if (size < max_unpacked_bytes / kMaxInflation) {
    most_bytes_ = size * kMaxInflation;
  } else {
    most_bytes_ = max_unpacked_bytes;
  }
}

ByteStream::~ByteStream() { gzclose_r(static_cast<gzFile>(file_)); }

Error ByteStream::Damaged(const std::string& what) const {
  return BadInput(path_.string() + ": near byte " + std::to_string(consumed_) + ": " + what);
}

bool ByteStream::Fill() {
  const gzFile file = static_cast<gzFile>(file_);
  if (consumed_ >= most_bytes_ && !gzdirect(file)) {
    throw Damaged("unpacks to more than is accepted; unpack it by hand if that is right");
  }
  const int n = gzread(file, buffer_.data(), static_cast<unsigned>(buffer_.size()));
  int code = Z_OK;
  const char* text = gzerror(file, &code);
  if (n < 0 || (n == 0 && code != Z_OK && code != Z_STREAM_END)) {
    throw Damaged(std::string("the compressed data are damaged or cut short (") + text +
                  "); copy the file again");
  }
  begin_ = 0;
  end_ = static_cast<std::size_t>(n);
  return n > 0;
}

void ByteStream::Read(void* data, std::size_t size) {
  auto* out = static_cast<unsigned char*>(data);
  while (size > 0) {
    if (begin_ == end_ && !Fill()) throw Damaged("the file ends early; copy it again");
    const std::size_t part = std::min(size, end_ - begin_);
    std::memcpy(out, buffer_.data() + begin_, part);
    out += part;
    begin_ += part;
    size -= part;
    consumed_ += static_cast<std::int64_t>(part);
  }
}

void ByteStream::Skip(std::int64_t size) {
  while (size > 0) {
    if (begin_ == end_ && !Fill()) throw Damaged("the file ends early; copy it again");
    const auto part = std::min(size, static_cast<std::int64_t>(end_ - begin_));
    begin_ += static_cast<std::size_t>(part);
    size -= part;
    consumed_ += part;
  }
}

int ByteStream::Get() {
  if (begin_ == end_ && !Fill()) return -1;
  ++consumed_;
  return buffer_[begin_++];
}

std::string ByteStream::Line() {
  std::string line;
  int c = 0;
  while ((c = Get()) != '\n') {
    if (c < 0) throw Damaged("the file ends within the header (no end_header line)");
    if (line.size() == kMaxLine) throw Damaged("a header line is longer than 4096 bytes");
    line += static_cast<char>(c);
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

std::string_view ByteStream::Word() {
  int c = Get();
  while (c >= 0 && std::isspace(c)) c = Get();
  if (c < 0) throw Damaged("the file ends early; copy it again");
  word_.clear();
  for (; c >= 0 && !std::isspace(c); c = Get()) {
    if (word_.size() == kMaxWord) throw Damaged("a word is too long for a number");
    word_ += static_cast<char>(c);
  }
  return word_;
}

int SizeOf(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kFloat64:
      return 8;
    default:
      return 4;
  }
}

double ReadNumber(ByteStream& in, Format format, Type type) {
  if (format == Format::kAscii) return ParseWord(in);
  unsigned char bytes[8];
  in.Read(bytes, static_cast<std::size_t>(SizeOf(type)));
  const bool swap =
      (format == Format::kLittleEndian) != (std::endian::native == std::endian::little);
  switch (type) {
    case Type::kInt8:
      return FromBytes<std::int8_t>(bytes, swap);
    case Type::kUint8:
      return FromBytes<std::uint8_t>(bytes, swap);
    case Type::kInt16:
      return FromBytes<std::int16_t>(bytes, swap);
    case Type::kUint16:
      return FromBytes<std::uint16_t>(bytes, swap);
    case Type::kInt32:
      return FromBytes<std::int32_t>(bytes, swap);
    case Type::kUint32:
      return FromBytes<std::uint32_t>(bytes, swap);
    case Type::kFloat32:
      return FromBytes<float>(bytes, swap);
    case Type::kFloat64:
      break;
  }
  return FromBytes<double>(bytes, swap);
}

}  // namespace livemvs::ply
