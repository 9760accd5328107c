#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "livemvs/core/frame.h"
#include "livemvs/core/image.h"

namespace livemvs {

struct VideoWriterOptions {
  int width = 0;   ///< [px], even.
  int height = 0;  ///< [px], even.
  double frames_per_second = 30;
  int crf = 18;                     ///< Constant quality of x264: 0 lossless ... 51 worst.
  std::string preset = "veryfast";  ///< Speed of x264: ultrafast ... veryslow.
  int keyframe_interval = 30;       ///< At most so many frames from one key frame to the next.
  std::string encoder = "libx264";  ///< FFmpeg's name of it.
  bool full_range = false;          ///< Luma 0 ... 255; otherwise 16 ... 235.
  YuvMatrix matrix = YuvMatrix::kBt709;
};

/// Writes a video; the name's ending chooses the container (.mp4, .mov, .mkv, .webm, .avi). The
/// file appears when Finish() has been called, whole or not at all. Not thread-safe.
class VideoWriter {
 public:
  /// @throws Error (kOutOfResource) where the file cannot be written, Error (kFailed) where FFmpeg
  /// lacks the encoder, std::invalid_argument for options that make no sense.
  VideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options);
  ~VideoWriter();

  /// Appends one picture of the size in the options. Luma and chroma of a Picture that has the
  /// range, matrix and 4:2:0 sub-sampling of the video are passed to the encoder as they are.
  /// @param timestamp  [s], later than the one before; without it, frames are evenly spaced.
  void Write(const Picture& picture, std::optional<double> timestamp = {});
  void Write(const Image<std::uint8_t>& grey, std::optional<double> timestamp = {});
  void Write(const Image<Rgb>& rgb, std::optional<double> timestamp = {});

  /// Completes the file. Without it nothing appears.
  void Finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livemvs
