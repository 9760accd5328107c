#include "livemvs/io/live_decoder.h"

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

bool IsSupported(AVCodecID id) {
  switch (id) {
    case AV_CODEC_ID_RAWVIDEO:
    case AV_CODEC_ID_MJPEG:
    case AV_CODEC_ID_H264:
    case AV_CODEC_ID_HEVC:
    case AV_CODEC_ID_MPEG4:
    case AV_CODEC_ID_VP8:
    case AV_CODEC_ID_VP9:
      return true;
    default:
      return false;
  }
}

}  // namespace

void CheckPictureSize(const std::string& name, int width, int height) {
  if (width > 0 && height > 0 && width <= ffmpeg::kMaxSide && height <= ffmpeg::kMaxSide) return;
  throw BadInput(name + ": its picture size " + std::to_string(width) + " x " +
                 std::to_string(height) + " is damaged or beyond 16384 x 16384");
}

LiveDecoder::LiveDecoder(const std::string& name, const AVCodecParameters& parameters)
    : name_(name), width_(parameters.width), height_(parameters.height) {
  ffmpeg::Silence();
  CheckPictureSize(name, width_, height_);
  const AVCodec* codec =
      IsSupported(parameters.codec_id) ? avcodec_find_decoder(parameters.codec_id) : nullptr;
  if (codec == nullptr) {
    throw BadInput(name + ": pictures in the format " + avcodec_get_name(parameters.codec_id) +
                   " cannot be read; use Motion JPEG, H.264 or raw frames");
  }
  decoder_ = ffmpeg::MakeCodecContext(codec);
  int result = avcodec_parameters_to_context(decoder_.get(), &parameters);
  // Frame threads would hold pictures back.
  decoder_->thread_count = 2;
  decoder_->thread_type = FF_THREAD_SLICE;
  decoder_->err_recognition |= AV_EF_EXPLODE;
  decoder_->max_pixels = ffmpeg::kMaxPixels;
  if (result >= 0) result = avcodec_open2(decoder_.get(), codec, nullptr);
  if (result < 0) {
    throw BadInput(name + ": its " + codec->name + " stream cannot be decoded (" +
                   ffmpeg::ErrorText(result) + ")");
  }
}

void LiveDecoder::Send(const AVPacket& packet) {
  if ((packet.flags & AV_PKT_FLAG_CORRUPT) != 0 ||
      avcodec_send_packet(decoder_.get(), &packet) < 0) {
    ++damaged_;
  }
}

void LiveDecoder::Drain() { avcodec_send_packet(decoder_.get(), nullptr); }

std::optional<LiveDecoder::Output> LiveDecoder::Receive() {
  while (true) {
    const int result = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return std::nullopt;
    if (result == AVERROR(ENOMEM)) {
      throw Error(ErrorKind::kOutOfResource, name_ + ": out of memory while decoding");
    }
    // A size that changes on the way would not fit the calibration.
    const bool good = result >= 0 && (frame_->flags & AV_FRAME_FLAG_CORRUPT) == 0 &&
                      frame_->decode_error_flags == 0 && frame_->width == width_ &&
                      frame_->height == height_;
    if (!good) {
      ++damaged_;
      continue;
    }
    const std::int64_t pts =
        frame_->pts != AV_NOPTS_VALUE ? frame_->pts : frame_->best_effort_timestamp;
    return Output{converter_.Convert(*frame_), pts};
  }
}

}  // namespace livemvs
