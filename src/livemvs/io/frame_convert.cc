#include "livemvs/io/frame_convert.h"

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include "livemvs/core/error.h"

namespace livemvs::ffmpeg {
namespace {

AVPixelFormat FormatOf(const AVFrame& frame) { return static_cast<AVPixelFormat>(frame.format); }

bool IsGrey(const AVPixFmtDescriptor& desc) {
  return desc.nb_components <= 2 && !(desc.flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL));
}

bool IsRgb(const AVPixFmtDescriptor& desc) {
  return desc.flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL);
}

/// Whether luma and chroma bytes can be taken from the frame as they are.
bool IsPlain8Bit(AVPixelFormat format, const AVPixFmtDescriptor& desc) {
  if (IsRgb(desc) || desc.comp[0].depth != 8 || (desc.flags & AV_PIX_FMT_FLAG_BITSTREAM)) {
    return false;
  }
  if (format == AV_PIX_FMT_NV12 || format == AV_PIX_FMT_NV21 || format == AV_PIX_FMT_GRAY8) {
    return true;
  }
  return desc.nb_components >= 3 && (desc.flags & AV_PIX_FMT_FLAG_PLANAR) &&
         desc.comp[1].step == 1 && desc.comp[2].step == 1;
}

/// The formats that older code uses to say full range, as their plain twins.
AVPixelFormat WithoutJ(AVPixelFormat format) {
  switch (format) {
    case AV_PIX_FMT_YUVJ420P:
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P:
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ444P:
      return AV_PIX_FMT_YUV444P;
    case AV_PIX_FMT_YUVJ440P:
      return AV_PIX_FMT_YUV440P;
    case AV_PIX_FMT_YUVJ411P:
      return AV_PIX_FMT_YUV411P;
    default:
      return format;
  }
}

/// The 8-bit planar format with the sub-sampling of another.
AVPixelFormat Nearest8Bit(const AVPixFmtDescriptor& desc) {
  if (IsGrey(desc)) return AV_PIX_FMT_GRAY8;
  if (IsRgb(desc)) return AV_PIX_FMT_YUV444P;
  if (desc.log2_chroma_h >= 1) return AV_PIX_FMT_YUV420P;
  return desc.log2_chroma_w >= 1 ? AV_PIX_FMT_YUV422P : AV_PIX_FMT_YUV444P;
}

bool IsFullRange(const AVFrame& frame, const AVPixFmtDescriptor& desc) {
  if (IsRgb(desc)) return true;
  if (WithoutJ(FormatOf(frame)) != FormatOf(frame)) return true;
  if (frame.color_range == AVCOL_RANGE_UNSPECIFIED) return IsGrey(desc);
  return frame.color_range == AVCOL_RANGE_JPEG;
}

YuvMatrix MatrixOf(const AVFrame& frame, const AVPixFmtDescriptor& desc) {
  if (IsRgb(desc) || IsGrey(desc)) return YuvMatrix::kBt601;
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return YuvMatrix::kBt709;
    case AVCOL_SPC_UNSPECIFIED:
      // As players do: high definition is BT.709. JPEG says full range and is always BT.601.
      return !IsFullRange(frame, desc) && (frame.width >= 1280 || frame.height > 576)
                 ? YuvMatrix::kBt709
                 : YuvMatrix::kBt601;
    default:
      return YuvMatrix::kBt601;
  }
}

/// Bytes of one component, (height, width), `step` apart.
struct Plane {
  const std::uint8_t* data;
  std::ptrdiff_t line;
  std::ptrdiff_t step;
  int width;
  int height;
};

Plane PlaneOf(const AVFrame& frame, const AVPixFmtDescriptor& desc, int component) {
  const AVComponentDescriptor& comp = desc.comp[component];
  Plane plane{frame.data[comp.plane] + comp.offset,
              frame.linesize[comp.plane],
              comp.step,
              frame.width,
              frame.height};
  if (component > 0) {
    plane.width = AV_CEIL_RSHIFT(frame.width, desc.log2_chroma_w);
    plane.height = AV_CEIL_RSHIFT(frame.height, desc.log2_chroma_h);
  }
  return plane;
}

Image<std::uint8_t> CopyTurned(Plane in, const Orientation& orientation) {
  std::ptrdiff_t line = in.line;
  std::ptrdiff_t step = in.step;
  if (orientation.transpose) {
    std::swap(line, step);
    std::swap(in.width, in.height);
  }
  const std::uint8_t* origin = in.data;
  if (orientation.flip_x) {
    origin += (in.width - 1) * step;
    step = -step;
  }
  if (orientation.flip_y) {
    origin += (in.height - 1) * line;
    line = -line;
  }
  Image<std::uint8_t> out(in.width, in.height);
  for (int y = 0; y < in.height; ++y) {
    const std::uint8_t* from = origin + y * line;
    std::uint8_t* to = out.Row(y);
    if (step == 1) {
      std::memcpy(to, from, static_cast<std::size_t>(in.width));
    } else {
      for (int x = 0; x < in.width; ++x) to[x] = from[x * step];
    }
  }
  return out;
}

}  // namespace

bool OrientationFromMatrix(const std::int32_t* matrix, Orientation* orientation) {
  // (x', y') = (a x + c y, b x + d y) with the matrix (a b u, c d v, x y w).
  const auto sign = [](std::int32_t v) {
    constexpr std::int32_t kHalf = 1 << 15;
    return v > kHalf ? 1 : v < -kHalf ? -1 : 0;
  };
  const int a = sign(matrix[0]), b = sign(matrix[1]), c = sign(matrix[3]), d = sign(matrix[4]);
  if (a != 0 && d != 0 && b == 0 && c == 0) {
    *orientation = {false, a < 0, d < 0};
    return true;
  }
  if (a == 0 && d == 0 && b != 0 && c != 0) {
    *orientation = {true, c < 0, b < 0};
    return true;
  }
  return false;
}

Scaler MakeScaler(const ScaleSpec& spec, Scaler old) {
  constexpr int kFlags =
      SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT;
  Scaler scaler(sws_getCachedContext(old.release(),
                                     spec.width,
                                     spec.height,
                                     spec.from,
                                     spec.width,
                                     spec.height,
                                     spec.to,
                                     kFlags,
                                     nullptr,
                                     nullptr,
                                     nullptr));
  if (!scaler) {
    const char* from = av_get_pix_fmt_name(spec.from);
    throw Error(ErrorKind::kFailed,
                std::string("no conversion from pixel format ") + (from ? from : "unknown"));
  }
  sws_setColorspaceDetails(scaler.get(),
                           sws_getCoefficients(spec.from_matrix),
                           spec.from_full_range,
                           sws_getCoefficients(spec.to_matrix),
                           spec.to_full_range,
                           0,
                           1 << 16,
                           1 << 16);
  return scaler;
}

const AVFrame& FrameConverter::To8BitYuv(const AVFrame& frame) {
  const AVPixelFormat from = FormatOf(frame);
  const AVPixFmtDescriptor& desc = *av_pix_fmt_desc_get(from);
  const bool full = IsFullRange(frame, desc);
  const int matrix = MatrixOf(frame, desc) == YuvMatrix::kBt709 ? SWS_CS_ITU709 : SWS_CS_ITU601;
  const AVPixelFormat to = Nearest8Bit(desc);
  scaler_ = MakeScaler({frame.width, frame.height, from, to, matrix, matrix, full, full},
                       std::move(scaler_));
  scaled_ = MakeFrame();
  scaled_->width = frame.width;
  scaled_->height = frame.height;
  scaled_->format = to;
  scaled_->color_range = full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  scaled_->colorspace = matrix == SWS_CS_ITU709 ? AVCOL_SPC_BT709 : AVCOL_SPC_SMPTE170M;
  if (av_frame_get_buffer(scaled_.get(), 0) < 0) throw std::bad_alloc();
  sws_scale(
      scaler_.get(), frame.data, frame.linesize, 0, frame.height, scaled_->data, scaled_->linesize);
  return *scaled_;
}

Picture FrameConverter::Convert(const AVFrame& frame) {
  const AVPixFmtDescriptor* desc = av_pix_fmt_desc_get(FormatOf(frame));
  if (desc == nullptr || (desc->flags & AV_PIX_FMT_FLAG_HWACCEL)) {
    throw Error(ErrorKind::kFailed, "the decoder gives a pixel format that cannot be read");
  }
  if (!IsPlain8Bit(FormatOf(frame), *desc)) return Convert(To8BitYuv(frame));

  Picture picture;
  picture.full_range = IsFullRange(frame, *desc);
  picture.matrix = MatrixOf(frame, *desc);
  picture.grey = CopyTurned(PlaneOf(frame, *desc, 0), orientation_);
  if (desc->nb_components < 3) return picture;
  picture.cb = CopyTurned(PlaneOf(frame, *desc, 1), orientation_);
  picture.cr = CopyTurned(PlaneOf(frame, *desc, 2), orientation_);
  picture.chroma_shift_x = desc->log2_chroma_w;
  picture.chroma_shift_y = desc->log2_chroma_h;
  if (orientation_.transpose) std::swap(picture.chroma_shift_x, picture.chroma_shift_y);
  return picture;
}

}  // namespace livemvs::ffmpeg
