#pragma once

/// Where a muxer of FFmpeg writes to. Private to io/.

#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>

#include "livemvs/io/atomic_file.h"
#include "livemvs/io/ffmpeg_util.h"

namespace livemvs::ffmpeg {

/// Lets FFmpeg's muxer write into an AtomicFile. Exceptions wait in `problem` until C code is left.
struct Sink {
  AtomicFile file;
  std::exception_ptr problem;

  explicit Sink(const std::filesystem::path& path) : file(path) {}

  template <typename F>
  std::int64_t Guard(F&& f) {
    if (problem) return AVERROR(EIO);
    try {
      return f();
    } catch (...) {
      problem = std::current_exception();
      return AVERROR(EIO);
    }
  }
#if LIBAVFORMAT_VERSION_MAJOR >= 61
  using Bytes = const std::uint8_t*;
#else
  using Bytes = std::uint8_t*;
#endif
  static int Write(void* self, Bytes data, int size) {
    auto& sink = *static_cast<Sink*>(self);
    return static_cast<int>(sink.Guard([&] {
      sink.file.Write(data, static_cast<std::size_t>(size));
      return std::int64_t{size};
    }));
  }
  static std::int64_t Seek(void* self, std::int64_t offset, int whence) {
    auto& sink = *static_cast<Sink*>(self);
    return sink.Guard([&]() -> std::int64_t {
      if (whence == AVSEEK_SIZE) return sink.file.size();
      if (whence == SEEK_CUR) offset += sink.file.position();
      if (whence == SEEK_END) offset += sink.file.size();
      sink.file.Seek(offset);
      return offset;
    });
  }
};

struct MuxerDeleter {
  void operator()(AVFormatContext* format) const {
    if (format->pb != nullptr) {
      av_freep(&format->pb->buffer);
      avio_context_free(&format->pb);
    }
    avformat_free_context(format);
  }
};
using MuxerContext = std::unique_ptr<AVFormatContext, MuxerDeleter>;

}  // namespace livemvs::ffmpeg
