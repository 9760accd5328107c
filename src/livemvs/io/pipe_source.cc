#include "livemvs/io/pipe_source.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/live_decoder.h"
#include "livemvs/io/pipe_reader.h"

namespace livemvs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kSignBytes = 189;  // of a transport stream: a packet, and the next one's sign
constexpr int kBufferBytes = 1 << 16;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

bool IsRaw(const PipeOptions& options) { return !options.format.empty(); }

// FFmpeg's name of the demuxer, by the first bytes; empty: unknown.
std::string DemuxerOf(const std::vector<std::uint8_t>& head) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (text.starts_with("YUV4MPEG2 ")) return "yuv4mpegpipe";
  if (text.starts_with("\xFF\xD8\xFF")) return "mjpeg";
  if (text.starts_with("\x1A\x45\xDF\xA3")) return "matroska";
  if (text.size() >= kSignBytes && text[0] == 0x47 && text[188] == 0x47) return "mpegts";
  using std::string_view_literals::operator""sv;
  if (text.starts_with("\0\0\0\1"sv) || text.starts_with("\0\0\1"sv)) return "h264";
  return "";
}

// Whether the times of a form's pictures mean anything.
bool HasTimes(const std::string& demuxer) {
  return demuxer == "yuv4mpegpipe" || demuxer == "matroska" || demuxer == "mpegts";
}

/// The demuxer and decoder of what one writer sends.
class Stream {
 public:
  Stream(const std::string& name, const PipeOptions& options, PipeReader* reader);
  ~Stream() {
    if (io_ != nullptr) av_freep(&io_->buffer);
    avio_context_free(&io_);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  struct Output {
    Picture picture;
    std::optional<double> time;  ///< [s] in the stream.
  };
  /// Nothing at the end.
  std::optional<Output> Next();

  const AVStream& stream() const { return *stream_; }
  std::string demuxer() const { return demuxer_; }
  std::int64_t damaged() const { return decoder_ ? decoder_->damaged() : 0; }

 private:
  struct FormatDeleter {
    void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  };
  void Open(const std::string& name, const PipeOptions& options, PipeReader* reader);

  AVIOContext* io_ = nullptr;
  std::unique_ptr<AVFormatContext, FormatDeleter> format_;
  AVStream* stream_ = nullptr;
  std::string demuxer_;
  std::optional<LiveDecoder> decoder_;
  ffmpeg::Packet packet_ = ffmpeg::MakePacket();
  bool drained_ = false;
};

int ReadBytes(void* opaque, std::uint8_t* data, int size) {
  const std::size_t n =
      static_cast<PipeReader*>(opaque)->Read(data, static_cast<std::size_t>(size));
  return n > 0 ? static_cast<int>(n) : AVERROR_EOF;
}

Stream::Stream(const std::string& name, const PipeOptions& options, PipeReader* reader) {
  ffmpeg::Silence();
  if (IsRaw(options)) {
    demuxer_ = "rawvideo";
  } else {
    const std::vector<std::uint8_t> head = reader->Peek(kSignBytes);
    if (head.empty()) throw BadInput(name + ": nothing comes");
    demuxer_ = DemuxerOf(head);
    if (demuxer_.empty()) {
      throw BadInput(name +
                     ": what comes is neither Motion JPEG, y4m, an MPEG transport stream, Matroska "
                     "nor H.264; raw frames need --pipe-format");
    }
  }
  Open(name, options, reader);
  const int index = av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) throw BadInput(name + ": what comes holds no video");
  stream_ = format_->streams[index];
  decoder_.emplace(name, *stream_->codecpar);
}

void Stream::Open(const std::string& name, const PipeOptions& options, PipeReader* reader) {
  auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferBytes));
  if (buffer == nullptr) throw std::bad_alloc();
  io_ = avio_alloc_context(buffer, kBufferBytes, 0, reader, ReadBytes, nullptr, nullptr);
  AVFormatContext* raw = avformat_alloc_context();
  if (io_ == nullptr || raw == nullptr) throw std::bad_alloc();
  raw->pb = io_;
  AVDictionary* dictionary = nullptr;
  // Look at little before the first picture; nothing but this form, and no further files.
  av_dict_set(&dictionary, "probesize", "1000000", 0);
  av_dict_set(&dictionary, "analyzeduration", "500000", 0);
  av_dict_set(&dictionary, "fpsprobesize", "0", 0);
  av_dict_set(&dictionary, "protocol_whitelist", "", 0);
  av_dict_set(&dictionary, "format_whitelist", demuxer_.c_str(), 0);
  if (IsRaw(options)) {
    const std::string size = std::to_string(options.width) + "x" + std::to_string(options.height);
    av_dict_set(&dictionary, "video_size", size.c_str(), 0);
    av_dict_set(&dictionary, "pixel_format", options.format.c_str(), 0);
  }
  int result =
      avformat_open_input(&raw, nullptr, av_find_input_format(demuxer_.c_str()), &dictionary);
  av_dict_free(&dictionary);
  format_.reset(raw);
  if (result >= 0) result = avformat_find_stream_info(raw, nullptr);
  if (result < 0) {
    throw BadInput(name + ": what comes cannot be read as " + demuxer_ + " (" +
                   ffmpeg::ErrorText(result) + ")");
  }
}

std::optional<Stream::Output> Stream::Next() {
  constexpr int kMaxErrorsInARow = 100;
  int errors = 0;
  while (true) {
    if (std::optional<LiveDecoder::Output> output = decoder_->Receive()) {
      std::optional<double> time;
      if (HasTimes(demuxer_) && output->pts != AV_NOPTS_VALUE) {
        time = static_cast<double>(output->pts) * av_q2d(stream_->time_base);
      }
      return Output{std::move(output->picture), time};
    }
    const int result = av_read_frame(format_.get(), packet_.get());
    if (result == AVERROR_EOF ||
        (result < 0 && (io_->eof_reached || ++errors == kMaxErrorsInARow))) {
      if (drained_) return std::nullopt;
      drained_ = true;
      decoder_->Drain();
      continue;
    }
    if (result < 0) continue;
    if (packet_->stream_index == stream_->index) decoder_->Send(*packet_);
    av_packet_unref(packet_.get());
  }
}

class PipeSource final : public LiveSource {
 public:
  PipeSource(const std::filesystem::path& path, const PipeOptions& options)
      : name_(path == "-" ? "standard input" : path.string()), options_(options), reader_(path) {
    // Until the first picture, patience is limited.
    const Clock::time_point start = Clock::now();
    const auto impatient = [this, start] {
      return SecondsSince(start) > options_.open_timeout ||
             (options_.cancelled && options_.cancelled());
    };
    while (reader_.is_fifo() && !impatient() && !reader_.WaitForWriter()) continue;
    reader_.give_up = impatient;
    try {
      Connect();
      first_ = stream_->Next();
    } catch (const Error& e) {
      if (!impatient()) throw;
    }
    if (!first_) {
      throw BadInput(name_ + ": no picture came within " +
                     std::to_string(std::llround(options_.open_timeout)) +
                     " s; start the program that writes to it");
    }
    reader_.give_up = nullptr;
    Describe();
  }

  FrameSource::Info info() const override { return info_; }
  FrameSource::Statistics statistics() const override { return statistics_; }
  void Cancel() override { reader_.Cancel(); }

  Answer Next() override {
    Answer answer;
    if (reader_.cancelled()) return answer;
    if (stream_ == nullptr && !Reconnect()) return answer;
    std::optional<Stream::Output> output =
        first_ ? std::exchange(first_, std::nullopt) : stream_->Next();
    statistics_.skipped = skipped_before_ + stream_->damaged();
    if (!output) return Disconnect();
    answer.frame = MakeFrame(*std::move(output));
    answer.status = Status::kFrame;
    return answer;
  }

 private:
  void Connect() {
    stream_ = std::make_unique<Stream>(name_, options_, &reader_);
    stream_start_.reset();
  }

  bool Reconnect() {
    if (!reader_.WaitForWriter()) return false;
    try {
      Connect();
    } catch (const Error& e) {
      LogWarning(e.what());
      return false;
    }
    const AVCodecParameters& now = *stream_->stream().codecpar;
    if (now.width == info_.width && now.height == info_.height) return true;
    throw BadInput(name_ + ": the pictures are now " + std::to_string(now.width) + " x " +
                   std::to_string(now.height) + ", and were " + std::to_string(info_.width) +
                   " x " + std::to_string(info_.height));
  }

  Answer Disconnect() {
    Answer answer;
    skipped_before_ = statistics_.skipped;
    stream_.reset();
    if (reader_.cancelled()) return answer;
    answer.status = reader_.is_fifo() ? Status::kLost : Status::kEnded;
    answer.problem = name_ + ": its writer has gone";
    return answer;
  }

  SourceFrame MakeFrame(Stream::Output output) {
    if (!begin_) begin_ = Clock::now();
    const double now = SecondsSince(*begin_);
    double timestamp = now;
    if (output.time) {
      // A later stream begins when it came.
      if (!stream_start_) stream_start_ = now - *output.time;
      timestamp = *output.time + *stream_start_;
    }
    SourceFrame frame;
    frame.index = next_index_++;
    frame.timestamp = timestamp;
    frame.name = "frame " + std::to_string(frame.index);
    frame.picture = std::make_shared<const Picture>(std::move(output.picture));
    ++statistics_.decoded;
    return frame;
  }

  void Describe() {
    const AVStream& stream = stream_->stream();
    info_.width = stream.codecpar->width;
    info_.height = stream.codecpar->height;
    if (HasTimes(stream_->demuxer()) && stream.avg_frame_rate.num > 0 &&
        stream.avg_frame_rate.den > 0) {
      info_.frames_per_second = av_q2d(stream.avg_frame_rate);
    }
    info_.description = "pipe of " + std::string(avcodec_get_name(stream.codecpar->codec_id)) +
                        " pictures, " + std::to_string(info_.width) + " x " +
                        std::to_string(info_.height);
  }

  std::string name_;
  PipeOptions options_;
  PipeReader reader_;
  std::unique_ptr<Stream> stream_;
  std::optional<Stream::Output> first_;
  FrameSource::Info info_;
  FrameSource::Statistics statistics_;
  std::int64_t skipped_before_ = 0;
  std::int64_t next_index_ = 0;
  std::optional<Clock::time_point> begin_;
  std::optional<double> stream_start_;  ///< What to add to the stream's times.
};

void CheckRaw(const PipeOptions& options) {
  if (!IsRaw(options)) return;
  static constexpr const char* kFormats[] = {"yuyv422", "nv12", "yuv420p", "gray"};
  const bool known = std::any_of(
      std::begin(kFormats), std::end(kFormats), [&](const char* f) { return options.format == f; });
  if (!known) {
    throw std::invalid_argument("--pipe-format " + options.format +
                                ": must be yuyv422, nv12, yuv420p or gray, with the size");
  }
  CheckPictureSize("--pipe-format", options.width, options.height);
}

}  // namespace

bool IsPipe(const std::filesystem::path& path) {
  std::error_code error;
  return path == "-" || std::filesystem::is_fifo(path, error);
}

std::unique_ptr<LiveSource> OpenPipe(const std::filesystem::path& path,
                                     const PipeOptions& options) {
  CheckRaw(options);
  return std::make_unique<PipeSource>(path, options);
}

}  // namespace livemvs
