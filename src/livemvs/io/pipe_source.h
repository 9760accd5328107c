#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "livemvs/io/live_source.h"

namespace livemvs {

struct PipeOptions {
  /// "" finds out by the first bytes: Motion JPEG, y4m, MPEG transport stream, Matroska or H.264.
  /// Raw frames have no sign: "yuyv422", "nv12", "yuv420p" or "gray", and the size below.
  std::string format;
  int width = 0;                    ///< Of raw frames. [px]
  int height = 0;                   ///< Of raw frames. [px]
  double open_timeout = 10;         ///< For the first picture to come. [s]
  std::function<bool()> cancelled;  ///< Asked while waiting for it. May be empty.
};

/// Whether the path is a FIFO, or "-", which stands for standard input.
bool IsPipe(const std::filesystem::path& path);

/// Reads pictures from a FIFO or from standard input, as they come. Where the writer of a FIFO
/// goes away, the source is lost until there is another one, which begins a new stream; at the end
/// of standard input it has ended. Times are those of the stream where it has them, otherwise
/// those at which the pictures came.
/// @throws Error (kBadInput) naming the pipe and the remedy, where it is no pipe, or what comes is
/// no video that can be read, or nothing comes in time.
std::unique_ptr<LiveSource> OpenPipe(const std::filesystem::path& path, const PipeOptions& options);

}  // namespace livemvs
