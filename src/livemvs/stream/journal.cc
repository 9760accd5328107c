#include "livemvs/stream/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kWriteBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kReadBytes = std::size_t{1} << 18;

std::string Reason(int error) {
  const std::string text = std::generic_category().message(error);
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  return full ? "disk full (" + text + ")" : text;
}

}  // namespace

JournalWriter::JournalWriter(const fs::path& path) : path_(path) { Open(O_CREAT | O_EXCL); }

JournalWriter::JournalWriter(const fs::path& path,
                             std::int64_t valid_bytes,
                             std::uint32_t next_sequence)
    : path_(path), flushed_(valid_bytes), next_sequence_(next_sequence) {
  Open(0);
  if (::ftruncate(fd_, valid_bytes) != 0 || ::lseek(fd_, valid_bytes, SEEK_SET) != valid_bytes) {
    const int error = errno;
    ::close(fd_);
    fd_ = -1;
    throw Error(ErrorKind::kOutOfResource,
                path_.string() + ": cannot be continued: " + Reason(error));
  }
}

void JournalWriter::Open(int flags) {
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
  if (fd_ < 0) {
    throw Error(ErrorKind::kOutOfResource,
                path_.string() + ": cannot be written: " + Reason(errno));
  }
  // Two writers would spoil it. Where locks are not supported, nothing is locked.
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(fd_);
    fd_ = -1;
    throw Error(ErrorKind::kFailed,
                path_.string() + ": is being written by another program; wait for its end");
  }
}

JournalWriter::~JournalWriter() {
  try {
    if (!failed_) Flush();
  } catch (const Error&) {  // Who wants to know calls Flush() before.
  }
  if (fd_ >= 0) ::close(fd_);
}

void JournalWriter::CheckUsable() const {
  if (failed_) {
    throw Error(ErrorKind::kOutOfResource, path_.string() + ": an earlier write failed");
  }
}

void JournalWriter::Append(RecordType type, std::span<const std::uint8_t> payload) {
  CheckUsable();
  AppendRecord(type, next_sequence_, payload, &buffer_);
  ++next_sequence_;
  if (buffer_.size() >= kWriteBufferBytes) Flush();
}

void JournalWriter::Flush() {
  CheckUsable();
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int error = n < 0 ? errno : ENOSPC;
      // Of what was written, keep the whole records.
      std::size_t whole = 0;
      while (whole < done) {
        const ParseResult result =
            ParseRecord(std::span<const std::uint8_t>(buffer_).first(done).subspan(whole));
        if (result.status != ParseStatus::kRecord) break;
        whole += result.bytes_used;
      }
      flushed_ += static_cast<std::int64_t>(whole);
      Fail("write", error);
    }
    done += static_cast<std::size_t>(n);
  }
  flushed_ += static_cast<std::int64_t>(buffer_.size());
  buffer_.clear();
}

void JournalWriter::Sync() {
  Flush();
  // Pipes and some file systems cannot sync; that loses nothing but this promise.
  if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS && errno != ENOSYS) {
    Fail("sync", errno);
  }
}

int JournalWriter::DuplicateHandle() const {
  const int fd = ::fcntl(fd_, F_DUPFD_CLOEXEC, 0);
  if (fd >= 0) return fd;
  throw Error(ErrorKind::kOutOfResource, path_.string() + ": " + Reason(errno));
}

void JournalWriter::Fail(const char* what, int error) {
  failed_ = true;
  buffer_.clear();
  // A reader would stop there by itself; this only makes it tidy.
  if (::ftruncate(fd_, flushed_) != 0) errno = 0;
  throw Error(ErrorKind::kOutOfResource,
              path_.string() + ": cannot be written: " + what + ": " + Reason(error));
}

JournalReader::JournalReader(const fs::path& path) : path_(path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    throw BadInput(path.string() + ": is a directory; name the journal in it");
  }
  fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0) {
    throw BadInput(path.string() + ": cannot be read: " + std::generic_category().message(errno));
  }
  Fill();
  const std::size_t n = std::min<std::size_t>(buffer_.size(), 4);
  if (std::memcmp(buffer_.data(), kRecordMagic, n) != 0) {
    ::close(fd_);
    throw BadInput(path.string() + ": is not the journal of a scan");
  }
}

JournalReader::~JournalReader() {
  if (fd_ >= 0) ::close(fd_);
}

bool JournalReader::Fill() {
  // What was read before goes, so that the buffer stays as large as the largest record.
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  const std::size_t size = buffer_.size();
  buffer_.resize(size + kReadBytes);
  ssize_t n = 0;
  do {
    n = ::read(fd_, buffer_.data() + size, kReadBytes);
  } while (n < 0 && errno == EINTR);
  buffer_.resize(size + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  if (n < 0 && errno != EAGAIN) {
    throw Error(ErrorKind::kFailed,
                path_.string() + ": cannot be read: " + std::generic_category().message(errno));
  }
  return n > 0;
}

std::optional<Record> JournalReader::Next() {
  while (tail_ != Tail::kCorrupt) {
    const auto unread = std::span<const std::uint8_t>(buffer_).subspan(begin_);
    const ParseResult result = ParseRecord(unread);
    if (result.status == ParseStatus::kIncomplete) {
      if (Fill()) continue;
      tail_ = buffer_.size() > begin_ ? Tail::kTorn : Tail::kClean;
      return std::nullopt;
    }
    if (result.status == ParseStatus::kCorrupt || result.record.sequence != next_sequence_) {
      tail_ = Tail::kCorrupt;
      break;
    }
    begin_ += result.bytes_used;
    valid_bytes_ += static_cast<std::int64_t>(result.bytes_used);
    ++next_sequence_;
    return result.record;
  }
  return std::nullopt;
}

}  // namespace livemvs
