#pragma once

/// From FFmpeg's frames to pictures and back. Private to io/.

#include "livemvs/core/frame.h"
#include "livemvs/io/ffmpeg_util.h"

namespace livemvs::ffmpeg {

/// A turn by a multiple of 90 degrees and mirroring: first the transposition, then the flips.
struct Orientation {
  bool transpose = false;
  bool flip_x = false;
  bool flip_y = false;

  bool IsIdentity() const { return !transpose && !flip_x && !flip_y; }
};

/// The orientation that a container's display matrix asks for: 9 numbers, 16.16 fixed point, as
/// AV_PKT_DATA_DISPLAYMATRIX has them. Turns that are no multiple of 90 degrees give false.
bool OrientationFromMatrix(const std::int32_t* matrix, Orientation* orientation);

/// Turns decoded frames into pictures. Planar 8-bit YUV and NV12 are copied; other formats go
/// through swscale. Keeps its scaler from frame to frame. Not thread-safe.
class FrameConverter {
 public:
  explicit FrameConverter(const Orientation& orientation = {}) : orientation_(orientation) {}

  /// @throws Error (kFailed) where swscale does not know the frame's format.
  Picture Convert(const AVFrame& frame);

 private:
  const AVFrame& To8BitYuv(const AVFrame& frame);

  Orientation orientation_;
  Frame scaled_;
  Scaler scaler_;
};

/// A scaler between two formats of the same size, exact rather than fast; colour matrices are
/// swscale's (SWS_CS_...), ranges true for full. Takes over and may return `old`.
/// @throws Error (kFailed) where swscale knows no way from one format to the other.
struct ScaleSpec {
  int width = 0;
  int height = 0;
  AVPixelFormat from = AV_PIX_FMT_NONE;
  AVPixelFormat to = AV_PIX_FMT_NONE;
  int from_matrix = SWS_CS_ITU601;
  int to_matrix = SWS_CS_ITU601;
  bool from_full_range = false;
  bool to_full_range = false;
};
Scaler MakeScaler(const ScaleSpec& spec, Scaler old);

}  // namespace livemvs::ffmpeg
