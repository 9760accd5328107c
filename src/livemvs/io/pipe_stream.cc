#include "livemvs/io/pipe_stream.h"

#include <cstdint>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr std::size_t kSignBytes = 189;  // of a transport stream: a packet, and the next one's sign
constexpr int kBufferBytes = 1 << 16;

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

int ReadBytes(void* opaque, std::uint8_t* data, int size) {
  const std::size_t n =
      static_cast<PipeReader*>(opaque)->Read(data, static_cast<std::size_t>(size));
  return n > 0 ? static_cast<int>(n) : AVERROR_EOF;
}

}  // namespace

PipeStream::PipeStream(const std::string& name, const PipeOptions& options, PipeReader* reader) {
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

void PipeStream::Open(const std::string& name, const PipeOptions& options, PipeReader* reader) {
  auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferBytes));
  if (buffer == nullptr) throw std::bad_alloc();
  io_.reset(avio_alloc_context(buffer, kBufferBytes, 0, reader, ReadBytes, nullptr, nullptr));
  AVFormatContext* raw = avformat_alloc_context();
  if (io_ == nullptr || raw == nullptr) throw std::bad_alloc();
  raw->pb = io_.get();
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

bool PipeStream::has_times() const { return HasTimes(demuxer_); }

std::optional<PipeStream::Output> PipeStream::Next() {
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

}  // namespace livemvs
