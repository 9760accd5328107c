#include "livemvs/io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferSize = 1 << 18;

Error CannotWrite(const fs::path& path, const std::string& why) {
  return Error(ErrorKind::kOutOfResource, path.string() + ": cannot be written: " + why);
}

std::string Reason(int error) {
  const std::string text = std::generic_category().message(error);
  return error == ENOSPC || error == EDQUOT ? "disk full (" + text +
                                                  "); free some space or choose "
                                                  "another disk"
                                            : text;
}

fs::path DirectoryOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Where a write to `path` ends up, so that a rename does not replace a symbolic link.
fs::path ResolveLinks(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target;
}

/// Opens a new file beside `target` for writing; -1 and errno on failure.
int OpenTemporary(const fs::path& target, fs::path* temporary) {
  for (int i = 0; i < 1000; ++i) {
    *temporary = target;
    *temporary += ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(i);
    const int fd = ::open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

bool IsDeviceOrPipe(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::is_character_file(status) || fs::is_fifo(status) || fs::is_socket(status);
}

void SyncDirectory(const fs::path& directory) {
  // Some file systems cannot sync a directory; the file itself is safe already.
  const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

void CheckTarget(const fs::path& path) {
  if (path.empty()) throw CannotWrite("(empty path)", "no file name given");
  std::error_code error;
  if (fs::is_directory(path, error) || !path.has_filename()) {
    throw CannotWrite(path, "it is a directory; name a file in it");
  }
  const fs::path directory = DirectoryOf(ResolveLinks(path));
  if (!fs::exists(directory, error)) {
    throw CannotWrite(path, "the directory " + directory.string() + " does not exist; create it");
  }
  if (!fs::is_directory(directory, error)) {
    throw CannotWrite(path, directory.string() + " is not a directory");
  }
  if (fs::exists(path, error) && ::access(path.c_str(), W_OK) != 0) {
    throw CannotWrite(path, Reason(errno) + "; choose another name or remove the file");
  }
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& path) : path_(path) {
  CheckTarget(path);
  target_ = ResolveLinks(path);
  if (IsDeviceOrPipe(target_)) {
    fd_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    fd_ = OpenTemporary(target_, &temporary_);
  }
  if (fd_ < 0) {
    const int error = errno;
    temporary_.clear();
    throw CannotWrite(path, Reason(error));
  }
  buffer_.reserve(kBufferSize);
}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::Fail(const char* what, int error) {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
  throw CannotWrite(path_, std::string(what) + ": " + Reason(error));
}

void AtomicFile::Write(const void* data, std::size_t size) {
  if (fd_ < 0) Fail("write", EBADF);
  const char* bytes = static_cast<const char*>(data);
  position_ += static_cast<std::int64_t>(size);
  size_ = std::max(size_, position_);
  while (size > 0) {
    const std::size_t part = std::min(size, kBufferSize - buffer_.size());
    buffer_.insert(buffer_.end(), bytes, bytes + part);
    bytes += part;
    size -= part;
    if (buffer_.size() == kBufferSize) Flush();
  }
}

void AtomicFile::Flush() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) Fail("write", n < 0 ? errno : EIO);
    done += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

void AtomicFile::Seek(std::int64_t offset) {
  if (fd_ < 0) Fail("seek", EBADF);
  Flush();
  if (::lseek(fd_, offset, SEEK_SET) != offset) Fail("seek", errno);
  position_ = offset;
}

void AtomicFile::Commit() {
  if (fd_ < 0) Fail("commit", EBADF);
  Flush();
  const bool renames = !temporary_.empty();
  if (renames && ::fsync(fd_) != 0) Fail("sync", errno);
  const int fd = fd_;
  fd_ = -1;
  if (::close(fd) != 0 && errno != EINTR) Fail("close", errno);
  if (!renames) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) Fail("rename", errno);
  temporary_.clear();
  SyncDirectory(DirectoryOf(target_));
}

void CheckWritable(const fs::path& path) {
  // The permission bits do not tell all (read-only file systems, over-long names): try it.
  try {
    AtomicFile probe(path);
  } catch (const Error& e) {
    throw BadInput(e.what());
  }
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw Error(ErrorKind::kOutOfResource,
                folder.string() + ": cannot make the folder: " + error.message());
  }
}

}  // namespace livemvs
