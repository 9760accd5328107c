#pragma once

/// The pictures of one writer to a pipe. Private to io/.

#include <memory>
#include <optional>
#include <string>

#include "livemvs/io/live_decoder.h"
#include "livemvs/io/pipe_reader.h"
#include "livemvs/io/pipe_source.h"

namespace livemvs {

/// The demuxer and decoder of what one writer sends.
class PipeStream {
 public:
  PipeStream(const std::string& name, const PipeOptions& options, PipeReader* reader);

  struct Output {
    Picture picture;
    std::optional<double> time;  ///< [s] in the stream.
  };
  /// Nothing at the end.
  std::optional<Output> Next();

  const AVStream& stream() const { return *stream_; }
  /// Whether the times of the form mean anything.
  bool has_times() const;
  std::int64_t damaged() const { return decoder_ ? decoder_->damaged() : 0; }

 private:
  struct IoDeleter {
    void operator()(AVIOContext* p) const {
      av_freep(&p->buffer);
      avio_context_free(&p);
    }
  };
  struct FormatDeleter {
    void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  };
  void Open(const std::string& name, const PipeOptions& options, PipeReader* reader);

  std::unique_ptr<AVIOContext, IoDeleter> io_;  ///< Outlives what reads by it.
  std::unique_ptr<AVFormatContext, FormatDeleter> format_;
  AVStream* stream_ = nullptr;
  std::string demuxer_;
  std::optional<LiveDecoder> decoder_;
  ffmpeg::Packet packet_ = ffmpeg::MakePacket();
  bool drained_ = false;
};

/// Whether the options say that the pictures are raw.
inline bool IsRaw(const PipeOptions& options) { return !options.format.empty(); }

}  // namespace livemvs
