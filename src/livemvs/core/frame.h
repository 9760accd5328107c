#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/pose.h"

namespace livemvs {

using Rgb = std::array<std::uint8_t, 3>;

/// How luma and chroma combine to red, green and blue.
enum class YuvMatrix { kBt601, kBt709 };

/// One picture as a decoder gives it: luma, which is the grey image all matching uses, and chroma,
/// which is read only where a point converges. Move-only.
struct Picture {
  Image<std::uint8_t> grey;    ///< (height, width) luma.
  Image<std::uint8_t> cb, cr;  ///< Chroma, sub-sampled as below; empty: a grey picture.
  int chroma_shift_x = 0;      ///< log2 of the horizontal sub-sampling.
  int chroma_shift_y = 0;      ///< log2 of the vertical sub-sampling.
  bool full_range = false;     ///< Luma 0 ... 255; otherwise 16 ... 235.
  YuvMatrix matrix = YuvMatrix::kBt601;

  int width() const { return grey.width(); }
  int height() const { return grey.height(); }

  /// The colour of the pixel (x, y), which must lie in the picture.
  Rgb ColorAt(int x, int y) const;
};

/// A picture with everything Algorithm 1 needs to know of its camera.
struct PosedFrame {
  std::int64_t index = 0;  ///< Number of the frame in its source, from 0.
  double timestamp = 0;    ///< [s]
  std::string name;        ///< For messages: file name or frame number.
  std::shared_ptr<const Picture> picture;
  Camera camera;
  Rigid3d cam_from_world;
};

}  // namespace livemvs
