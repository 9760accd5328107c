#include "livemvs/io/video_container.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

using Head = std::array<unsigned char, 16>;

void CheckFile(const fs::path& path) {
  const std::string name = path.string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw BadInput(name + ": there is no such file");
  if (fs::is_directory(status)) {
    throw BadInput(name + ": is a directory, not a video; name the file in it");
  }
  if (!fs::is_regular_file(status)) throw BadInput(name + ": is not an ordinary file");
  if (fs::file_size(path, error) == 0) {
    throw BadInput(name + ": is empty (0 bytes); copy or record it again");
  }
}

Head ReadHead(const fs::path& path, std::size_t* size) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    throw BadInput(path.string() + ": cannot be opened for reading; check its permissions");
  }
  Head head{};
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  *size = static_cast<std::size_t>(in.gcount());
  return head;
}

bool IsText(const Head& head, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    const bool printable = (head[i] >= 0x20 && head[i] < 0x7f) || head[i] >= 0x80;
    if (!printable && head[i] != '\n' && head[i] != '\r' && head[i] != '\t') return false;
  }
  return true;
}

bool IsMp4Atom(std::string_view type) {
  for (const char* known : {"ftyp", "moov", "mdat", "free", "skip", "wide", "pnot", "uuid"}) {
    if (type == known) return true;
  }
  return false;
}

std::uint64_t BigEndian(const unsigned char* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

}  // namespace

std::string DemuxerOf(const fs::path& path) {
  CheckFile(path);
  std::size_t size = 0;
  const Head head = ReadHead(path, &size);
  const char* text = reinterpret_cast<const char*>(head.data());
  if (size >= 8 && IsMp4Atom({text + 4, 4})) return "mov";
  if (size >= 4 && BigEndian(head.data(), 4) == 0x1A45DFA3) return "matroska";
  if (size >= 12 && std::memcmp(text, "RIFF", 4) == 0 && std::memcmp(text + 8, "AVI ", 4) == 0) {
    return "avi";
  }
  throw BadInput(path.string() + ": is no MP4, MOV, MKV, WebM or AVI video" +
                 (IsText(head, size) ? ", it looks like text" : "") +
                 "; convert it, for instance by: ffmpeg -i IN -c:v libx264 -crf 18 OUT.mp4");
}

bool LacksMp4Index(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::error_code error;
  const std::uint64_t file_size = fs::file_size(path, error);
  std::uint64_t offset = 0;
  constexpr int kMaxAtoms = 100'000;
  for (int i = 0; i < kMaxAtoms && !error && offset + 8 <= file_size; ++i) {
    Head head{};
    in.clear();
    in.seekg(static_cast<std::streamoff>(offset));
    in.read(reinterpret_cast<char*>(head.data()), head.size());
    if (in.gcount() < 8) break;
    if (std::memcmp(head.data() + 4, "moov", 4) == 0) return false;
    std::uint64_t atom_size = BigEndian(head.data(), 4);
    if (atom_size == 1) atom_size = BigEndian(head.data() + 8, 8);
    if (atom_size < 8 || atom_size > file_size - offset) break;  // The last, or cut.
    offset += atom_size;
  }
  return true;
}

}  // namespace livemvs
