#pragma once

/// Decodes what comes from a camera or a pipe, picture by picture. Private to io/.

#include <optional>
#include <string>

#include "livemvs/core/frame.h"
#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/frame_convert.h"

namespace livemvs {

/// Not thread-safe. Damage costs the pictures that are damaged.
class LiveDecoder {
 public:
  /// @param name  Of the device or pipe, for messages.
  /// @throws Error (kBadInput) where the stream's codec or size cannot be decoded.
  LiveDecoder(const std::string& name, const AVCodecParameters& parameters);

  /// Gives the decoder a packet. Damaged ones are counted.
  void Send(const AVPacket& packet);

  /// No more packets come: Receive() gives the pictures that were held back.
  void Drain();

  struct Output {
    Picture picture;
    std::int64_t pts = AV_NOPTS_VALUE;  ///< In the stream's time base.
  };
  /// The next picture that is ready; nothing: send more.
  std::optional<Output> Receive();

  std::int64_t damaged() const { return damaged_; }

 private:
  std::string name_;
  ffmpeg::CodecContext decoder_;
  ffmpeg::Frame frame_ = ffmpeg::MakeFrame();
  ffmpeg::FrameConverter converter_;
  int width_;
  int height_;
  std::int64_t damaged_ = 0;
};

/// @throws Error (kBadInput) naming what it is of, where the size is damaged or beyond what is
/// read.
void CheckPictureSize(const std::string& name, int width, int height);

}  // namespace livemvs
