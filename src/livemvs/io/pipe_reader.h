#pragma once

/// Bytes of a pipe, read with patience that ends. Private to io/.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace livemvs {

/// Not thread-safe, but for Cancel().
class PipeReader {
 public:
  /// @param path  A FIFO, or "-".
  /// @throws Error (kBadInput) where it cannot be opened.
  explicit PipeReader(const std::filesystem::path& path);
  ~PipeReader();
  PipeReader(const PipeReader&) = delete;
  PipeReader& operator=(const PipeReader&) = delete;

  /// Up to `size` bytes, as soon as there are any; 0 where the writer went away or Cancel() was
  /// called, or `give_up` says so, which is asked ten times a second.
  std::size_t Read(std::uint8_t* data, std::size_t size);
  std::function<bool()> give_up;

  /// As Read(), but leaves the bytes for the next Read(). Waits for all of them.
  /// @return Fewer where no more come.
  std::vector<std::uint8_t> Peek(std::size_t size);

  /// After the writer of a FIFO went away: waits up to 0.1 s for another.
  /// @return Whether there are bytes of it.
  bool WaitForWriter();

  bool is_fifo() const { return is_fifo_; }
  void Cancel() { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }

 private:
  int OpenFifo() const;

  std::filesystem::path path_;
  int fd_ = -1;
  bool is_fifo_ = false;
  bool had_writer_ = false;
  std::vector<std::uint8_t> peeked_;
  std::atomic<bool> cancelled_ = false;
};

}  // namespace livemvs
