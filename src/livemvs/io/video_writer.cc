#include "livemvs/io/video_writer.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/frame_convert.h"
#include "livemvs/io/muxer_sink.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

/// Time stamps are multiples of this. [1/s]; MP4's usual 90 kHz, which holds all common rates.
constexpr int kTicksPerSecond = 90'000;

void CheckOptions(const VideoWriterOptions& options) {
  const auto check = [](bool good, const std::string& what) {
    if (!good) throw std::invalid_argument("VideoWriterOptions: " + what);
  };
  check(options.width > 0 && options.width % 2 == 0 && options.width <= ffmpeg::kMaxSide,
        "width must be positive and even, is " + std::to_string(options.width));
  check(options.height > 0 && options.height % 2 == 0 && options.height <= ffmpeg::kMaxSide,
        "height must be positive and even, is " + std::to_string(options.height));
  check(options.frames_per_second > 0 && options.frames_per_second <= 10'000,
        "frames_per_second must be in (0, 10000]");
  check(options.crf >= 0 && options.crf <= 63, "crf must be in [0, 63]");
  check(options.keyframe_interval > 0, "keyframe_interval must be positive");
}

/// A frame of FFmpeg over the pixels of ours, which must outlive it.
struct BorrowedFrame {
  ffmpeg::Frame frame = ffmpeg::MakeFrame();

  BorrowedFrame(int width, int height, AVPixelFormat format, bool full_range, YuvMatrix matrix) {
    frame->width = width;
    frame->height = height;
    frame->format = format;
    frame->color_range = full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    frame->colorspace = matrix == YuvMatrix::kBt709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  }
  template <typename T>
  void SetPlane(int i, const Image<T>& image) {
    // FFmpeg does not write into what it is given to scale.
    frame->data[i] = const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(image.Row(0)));
    frame->linesize[i] = static_cast<int>(image.stride() * static_cast<int>(sizeof(T)));
  }
};

AVPixelFormat FormatOf(const Picture& picture) {
  if (picture.cb.empty()) return AV_PIX_FMT_GRAY8;
  const std::pair<int, int> shifts(picture.chroma_shift_x, picture.chroma_shift_y);
  if (shifts == std::pair(1, 1)) return AV_PIX_FMT_YUV420P;
  if (shifts == std::pair(1, 0)) return AV_PIX_FMT_YUV422P;
  if (shifts == std::pair(0, 0)) return AV_PIX_FMT_YUV444P;
  if (shifts == std::pair(0, 1)) return AV_PIX_FMT_YUV440P;
  throw std::invalid_argument("VideoWriter: the picture's chroma sub-sampling is not supported");
}

int SwsMatrix(bool bt709) { return bt709 ? SWS_CS_ITU709 : SWS_CS_ITU601; }

}  // namespace

class VideoWriter::Impl {
 public:
  Impl(const fs::path& path, const VideoWriterOptions& options)
      : path_(path), options_(options), sink_(path) {
    OpenMuxer();
    OpenEncoder();
    stream_ = avformat_new_stream(format_.get(), nullptr);
    if (stream_ == nullptr) throw std::bad_alloc();
    stream_->time_base = encoder_->time_base;
    stream_->avg_frame_rate = encoder_->framerate;
    Check(avcodec_parameters_from_context(stream_->codecpar, encoder_.get()), "encoder");
    Check(avformat_write_header(format_.get(), nullptr), "header");
  }

  void Write(const AVFrame& in, std::optional<double> timestamp) {
    if (finished_) throw std::invalid_argument("VideoWriter: Write after Finish");
    if (in.width != options_.width || in.height != options_.height) {
      throw std::invalid_argument("VideoWriter: the picture is not of the video's size");
    }
    const double seconds =
        timestamp.value_or(static_cast<double>(count_) / options_.frames_per_second);
    const auto pts = static_cast<std::int64_t>(std::llround(seconds / av_q2d(encoder_->time_base)));
    if (count_ > 0 && pts <= last_pts_) {
      throw std::invalid_argument("VideoWriter: time stamps must grow from frame to frame");
    }
    const ffmpeg::Frame out = ToVideoFormat(in);
    out->pts = pts;
    last_pts_ = pts;
    ++count_;
    Encode(out.get());
  }

  void Finish() {
    if (std::exchange(finished_, true)) return;
    Encode(nullptr);
    Check(av_write_trailer(format_.get()), "end of the file");
    avio_flush(format_->pb);
    Check(format_->pb->error, "end of the file");
    sink_.file.Commit();
  }

 private:
  /// Turns FFmpeg's failures into exceptions, those of the file first.
  void Check(int result, const char* place) {
    if (sink_.problem) std::rethrow_exception(sink_.problem);
    if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (result < 0) {
      throw Error(ErrorKind::kFailed,
                  path_.string() + ": the video cannot be written: " + place + ": " +
                      ffmpeg::ErrorText(result));
    }
  }

  void OpenMuxer() {
    AVFormatContext* raw = nullptr;
    avformat_alloc_output_context2(&raw, nullptr, nullptr, path_.c_str());
    format_.reset(raw);
    if (format_ == nullptr) {
      throw std::invalid_argument("VideoWriter: " + path_.string() +
                                  ": the ending must be .mp4, .mov, .mkv, .webm or .avi");
    }
    format_->flags |= AVFMT_FLAG_BITEXACT;  // No dates or versions.
    constexpr int kBufferSize = 1 << 16;
    auto* buffer = static_cast<unsigned char*>(av_malloc(kBufferSize));
    format_->pb = avio_alloc_context(
        buffer, kBufferSize, 1, &sink_, nullptr, &ffmpeg::Sink::Write, &ffmpeg::Sink::Seek);
    if (format_->pb == nullptr) throw std::bad_alloc();
    format_->flags |= AVFMT_FLAG_CUSTOM_IO;
  }

  void OpenEncoder() {
    const AVCodec* codec = avcodec_find_encoder_by_name(options_.encoder.c_str());
    if (codec == nullptr) {
      throw Error(
          ErrorKind::kFailed,
          path_.string() + ": this FFmpeg was built without the encoder " + options_.encoder);
    }
    encoder_ = ffmpeg::MakeCodecContext(codec);
    encoder_->width = options_.width;
    encoder_->height = options_.height;
    encoder_->pix_fmt = codec->id == AV_CODEC_ID_MJPEG ? AV_PIX_FMT_YUVJ420P : AV_PIX_FMT_YUV420P;
    encoder_->framerate = av_d2q(options_.frames_per_second, 100'000);
    // AVI numbers its frames, others have time stamps.
    const bool is_avi = std::strcmp(format_->oformat->name, "avi") == 0;
    encoder_->time_base = is_avi ? av_inv_q(encoder_->framerate) : AVRational{1, kTicksPerSecond};
    encoder_->gop_size = options_.keyframe_interval;
    encoder_->color_range = options_.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    const bool bt709 = options_.matrix == YuvMatrix::kBt709;
    encoder_->colorspace = bt709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
    encoder_->color_primaries = bt709 ? AVCOL_PRI_BT709 : AVCOL_PRI_SMPTE170M;
    encoder_->color_trc = bt709 ? AVCOL_TRC_BT709 : AVCOL_TRC_SMPTE170M;
    encoder_->thread_count = 2;  // Fixed, because x264's output depends on it.
    encoder_->flags |= AV_CODEC_FLAG_BITEXACT;
    if (format_->oformat->flags & AVFMT_GLOBALHEADER) {
      encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    SetQuality(codec->id);
    Check(avcodec_open2(encoder_.get(), codec, nullptr), "the encoder refuses its options");
  }

  void SetQuality(AVCodecID codec) {
    if (codec == AV_CODEC_ID_MJPEG) {  // Knows no crf.
      encoder_->flags |= AV_CODEC_FLAG_QSCALE;
      encoder_->global_quality = FF_QP2LAMBDA * 3;
      return;
    }
    // Encoders differ in what they know; what one lacks is passed over.
    av_opt_set(encoder_->priv_data, "preset", options_.preset.c_str(), 0);
    av_opt_set(encoder_->priv_data, "x265-params", "log-level=none", 0);
    av_opt_set(encoder_->priv_data, "crf", std::to_string(options_.crf).c_str(), 0);
  }

  ffmpeg::Frame ToVideoFormat(const AVFrame& in) {
    ffmpeg::Frame out = ffmpeg::MakeFrame();
    out->width = options_.width;
    out->height = options_.height;
    out->format = encoder_->pix_fmt;
    out->color_range = encoder_->color_range;
    out->colorspace = encoder_->colorspace;
    if (av_frame_get_buffer(out.get(), 0) < 0) throw std::bad_alloc();
    scaler_ = ffmpeg::MakeScaler({in.width,
                                  in.height,
                                  static_cast<AVPixelFormat>(in.format),
                                  encoder_->pix_fmt,
                                  SwsMatrix(in.colorspace == AVCOL_SPC_BT709),
                                  SwsMatrix(options_.matrix == YuvMatrix::kBt709),
                                  in.color_range == AVCOL_RANGE_JPEG,
                                  options_.full_range},
                                 std::move(scaler_));
    sws_scale(scaler_.get(), in.data, in.linesize, 0, in.height, out->data, out->linesize);
    return out;
  }

  void Encode(const AVFrame* frame) {
    Check(avcodec_send_frame(encoder_.get(), frame), "encoding");
    const ffmpeg::Packet packet = ffmpeg::MakePacket();
    while (true) {
      const int result = avcodec_receive_packet(encoder_.get(), packet.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
      Check(result, "encoding");
      if (packet->duration == 0) {
        packet->duration =
            std::llround(1 / (options_.frames_per_second * av_q2d(encoder_->time_base)));
      }
      av_packet_rescale_ts(packet.get(), encoder_->time_base, stream_->time_base);
      packet->stream_index = stream_->index;
      Check(av_interleaved_write_frame(format_.get(), packet.get()), "frame");
    }
  }

  fs::path path_;
  VideoWriterOptions options_;
  ffmpeg::Sink sink_;
  ffmpeg::MuxerContext format_;
  AVStream* stream_ = nullptr;
  ffmpeg::CodecContext encoder_;
  ffmpeg::Scaler scaler_;
  std::int64_t count_ = 0;
  std::int64_t last_pts_ = 0;
  bool finished_ = false;
};

VideoWriter::VideoWriter(const fs::path& path, const VideoWriterOptions& options) {
  CheckOptions(options);
  ffmpeg::Silence();
  impl_ = std::make_unique<Impl>(path, options);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::Write(const Picture& picture, std::optional<double> timestamp) {
  BorrowedFrame in(
      picture.width(), picture.height(), FormatOf(picture), picture.full_range, picture.matrix);
  in.SetPlane(0, picture.grey);
  if (!picture.cb.empty()) {
    in.SetPlane(1, picture.cb);
    in.SetPlane(2, picture.cr);
  }
  impl_->Write(*in.frame, timestamp);
}

void VideoWriter::Write(const Image<std::uint8_t>& grey, std::optional<double> timestamp) {
  BorrowedFrame in(grey.width(), grey.height(), AV_PIX_FMT_GRAY8, true, YuvMatrix::kBt601);
  in.SetPlane(0, grey);
  impl_->Write(*in.frame, timestamp);
}

void VideoWriter::Write(const Image<Rgb>& rgb, std::optional<double> timestamp) {
  BorrowedFrame in(rgb.width(), rgb.height(), AV_PIX_FMT_RGB24, true, YuvMatrix::kBt601);
  in.SetPlane(0, rgb);
  impl_->Write(*in.frame, timestamp);
}

void VideoWriter::Finish() { impl_->Finish(); }

}  // namespace livemvs
