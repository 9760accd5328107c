#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

namespace livemvs {

/// A file that appears whole or not at all: bytes go to a temporary file in the same directory,
/// which Commit() syncs and renames over `path`. Without Commit() the destructor removes the
/// temporary file and leaves what stood at `path` untouched. Devices and pipes (/dev/null) are
/// written directly.
///
/// Every failure throws Error (kOutOfResource) with the path and the system's reason, "no space
/// left on device" among them. Not thread-safe.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(const void* data, std::size_t size);
  void Write(std::string_view text) { Write(text.data(), text.size()); }

  /// Moves the place of the next Write(). [bytes from the start]
  void Seek(std::int64_t offset);

  std::int64_t position() const { return position_; }
  std::int64_t size() const { return size_; }

  /// Makes the file appear under its name, on disk. Nothing may be written afterwards.
  void Commit();

 private:
  void Flush();
  [[noreturn]] void Fail(const char* what, int error);

  std::filesystem::path path_;       ///< As the caller named it, for messages.
  std::filesystem::path target_;     ///< With symbolic links resolved.
  std::filesystem::path temporary_;  ///< Empty: written directly, or committed.
  int fd_ = -1;
  std::int64_t position_ = 0;
  std::int64_t size_ = 0;
  std::vector<char> buffer_;
};

/// Finds out before the work whether an AtomicFile could be made at `path`: its directory is there
/// and writable, and `path` is not a directory or a read-only file.
/// @throws Error (kBadInput) naming path and remedy.
void CheckWritable(const std::filesystem::path& path);

/// Makes a folder, and those above it that are missing.
/// @throws Error (kOutOfResource) naming it and the system's reason.
void MakeFolder(const std::filesystem::path& folder);

}  // namespace livemvs
