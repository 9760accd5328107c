#include "viewer/preview.h"

#include <algorithm>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libswscale/swscale.h>
}

namespace livemvs::viewer {
namespace {

// Of mjpeg's scale from 2 (best) to 31.
constexpr int kQuality = 7;

struct FreeContext {
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
};
struct FreeFrame {
  void operator()(AVFrame* p) const { av_frame_free(&p); }
};
struct FreePacket {
  void operator()(AVPacket* p) const { av_packet_free(&p); }
};
struct FreeScaler {
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};

AVPixelFormat FormatOf(const Picture& picture) {
  if (picture.cb.empty()) return AV_PIX_FMT_GRAY8;
  if (picture.chroma_shift_x == 1 && picture.chroma_shift_y == 1) return AV_PIX_FMT_YUV420P;
  if (picture.chroma_shift_x == 1 && picture.chroma_shift_y == 0) return AV_PIX_FMT_YUV422P;
  if (picture.chroma_shift_x == 0 && picture.chroma_shift_y == 0) return AV_PIX_FMT_YUV444P;
  return AV_PIX_FMT_GRAY8;
}

}  // namespace

struct PreviewEncoder::Impl {
  int most_width;
  int width = 0, height = 0;
  std::unique_ptr<AVCodecContext, FreeContext> codec;
  std::unique_ptr<AVFrame, FreeFrame> frame;
  std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
  std::unique_ptr<SwsContext, FreeScaler> scaler;

  bool Prepare(int w, int h);
  bool Scale(const Picture& picture);
};

PreviewEncoder::PreviewEncoder(int most_width) : impl_(std::make_unique<Impl>()) {
  impl_->most_width = most_width;
}

PreviewEncoder::~PreviewEncoder() = default;

bool PreviewEncoder::Impl::Prepare(int w, int h) {
  if (codec && w == width && h == height) return true;
  width = w;
  height = h;
  const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_MJPEG);
  if (encoder == nullptr) return false;
  codec.reset(avcodec_alloc_context3(encoder));
  frame.reset(av_frame_alloc());
  if (!codec || !frame || !packet) return false;
  codec->width = frame->width = w;
  codec->height = frame->height = h;
  codec->pix_fmt = AV_PIX_FMT_YUVJ420P;
  codec->color_range = AVCOL_RANGE_JPEG;
  codec->time_base = {1, 25};
  codec->thread_count = 1;
  codec->flags |= AV_CODEC_FLAG_QSCALE;
  codec->global_quality = kQuality * FF_QP2LAMBDA;
  frame->format = AV_PIX_FMT_YUVJ420P;
  frame->quality = codec->global_quality;
  if (av_frame_get_buffer(frame.get(), 0) < 0 || avcodec_open2(codec.get(), encoder, nullptr) < 0) {
    codec.reset();
    return false;
  }
  return true;
}

bool PreviewEncoder::Impl::Scale(const Picture& picture) {
  const AVPixelFormat format = FormatOf(picture);
  scaler.reset(sws_getCachedContext(scaler.release(),
                                    picture.width(),
                                    picture.height(),
                                    format,
                                    width,
                                    height,
                                    AV_PIX_FMT_YUV420P,
                                    SWS_AREA,
                                    nullptr,
                                    nullptr,
                                    nullptr));
  if (!scaler || av_frame_make_writable(frame.get()) < 0) return false;
  const int* matrix =
      sws_getCoefficients(picture.matrix == YuvMatrix::kBt709 ? SWS_CS_ITU709 : SWS_CS_ITU601);
  sws_setColorspaceDetails(scaler.get(),
                           matrix,
                           picture.full_range ? 1 : 0,
                           sws_getCoefficients(SWS_CS_ITU601),
                           1,
                           0,
                           1 << 16,
                           1 << 16);
  const bool grey = format == AV_PIX_FMT_GRAY8;
  const std::uint8_t* planes[4] = {picture.grey.Row(0),
                                   grey ? nullptr : picture.cb.Row(0),
                                   grey ? nullptr : picture.cr.Row(0),
                                   nullptr};
  const int strides[4] = {static_cast<int>(picture.grey.stride()),
                          grey ? 0 : static_cast<int>(picture.cb.stride()),
                          grey ? 0 : static_cast<int>(picture.cr.stride()),
                          0};
  return sws_scale(
             scaler.get(), planes, strides, 0, picture.height(), frame->data, frame->linesize) ==
         height;
}

std::vector<std::uint8_t> PreviewEncoder::Encode(const Picture& picture) {
  if (picture.width() < 2 || picture.height() < 2) return {};
  const double scale =
      std::min(1.0, static_cast<double>(impl_->most_width) / static_cast<double>(picture.width()));
  const auto even = [&](int size) { return std::max(2, static_cast<int>(size * scale) & ~1); };
  if (!impl_->Prepare(even(picture.width()), even(picture.height()))) return {};
  if (!impl_->Scale(picture)) return {};
  if (avcodec_send_frame(impl_->codec.get(), impl_->frame.get()) < 0 ||
      avcodec_receive_packet(impl_->codec.get(), impl_->packet.get()) < 0) {
    impl_->codec.reset();
    return {};
  }
  std::vector<std::uint8_t> jpeg(impl_->packet->data, impl_->packet->data + impl_->packet->size);
  av_packet_unref(impl_->packet.get());
  return jpeg;
}

double Sharpness(const ImageView<std::uint8_t>& grey) {
  // Every fourth row tells enough.
  std::int64_t sum = 0, count = 0;
  for (int y = 0; y < grey.height; y += 4) {
    const std::uint8_t* row = grey.Row(y);
    for (int x = 1; x < grey.width; ++x) {
      const int step = row[x] - row[x - 1];
      sum += step * step;
    }
    count += grey.width - 1;
  }
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : 0;
}

}  // namespace livemvs::viewer
