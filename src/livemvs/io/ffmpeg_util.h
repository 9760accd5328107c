#pragma once

/// Owners and small helpers around FFmpeg's C interface. Private to io/.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/frame.h>
#include <libswscale/swscale.h>
}

#include <cstdint>
#include <memory>
#include <string>

namespace livemvs::ffmpeg {

struct Deleter {
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};

using Frame = std::unique_ptr<AVFrame, Deleter>;
using Packet = std::unique_ptr<AVPacket, Deleter>;
using CodecContext = std::unique_ptr<AVCodecContext, Deleter>;
using Scaler = std::unique_ptr<SwsContext, Deleter>;

/// The most pixels that a picture may have. [px]
inline constexpr int kMaxSide = 16384;
inline constexpr std::int64_t kMaxPixels = std::int64_t{kMaxSide} * kMaxSide;

/// Stops FFmpeg from printing, since the library reports by exceptions and its own log alone. Call
/// it before anything else of FFmpeg.
void Silence();

/// FFmpeg's text for one of its error codes.
std::string ErrorText(int code);

/// As FFmpeg's allocators, but throw std::bad_alloc.
Frame MakeFrame();
Packet MakePacket();
CodecContext MakeCodecContext(const AVCodec* codec);

}  // namespace livemvs::ffmpeg
