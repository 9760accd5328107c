// Hostile bytes as a GLB file. The first byte chooses how the rest is used: as the file, or as its
// description, which ends with a NUL, and its numbers, with a header that fits them, which a file
// made by chance seldom has.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "file_input.h"
#include "livemvs/core/error.h"
#include "livemvs/exchange/glb.h"
#include "livemvs/io/little_endian.h"

namespace {

using namespace livemvs;

void AppendChunk(std::uint32_t type, const std::string& chunk, std::string* file) {
  AppendLittleEndian(file, static_cast<std::uint32_t>(chunk.size()));
  AppendLittleEndian(file, type);
  *file += chunk;
}

std::string MakeFile(const std::string& bytes) {
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  std::string file = "glTF";
  AppendLittleEndian(&file, std::uint32_t{2});
  AppendLittleEndian(&file, std::uint32_t{0});
  AppendChunk(0x4E4F534A, bytes.substr(0, end), &file);
  AppendChunk(0x004E4942, end < bytes.size() ? bytes.substr(end + 1) : "", &file);
  std::string size;
  AppendLittleEndian(&size, static_cast<std::uint32_t>(file.size()));
  return file.replace(8, 4, size);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0) bytes = MakeFile(bytes);
  try {
    const FileInput file({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    ReadGlb(file.path()).Check();  // what is read is whole
  } catch (const Error&) {
    return 0;
  }
  return 0;
}
