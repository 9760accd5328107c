#pragma once

/// The packets of a video file. Private to io/.

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>

#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/frame_convert.h"

namespace livemvs {

/// Hands out the packets of a file's video stream, and keeps account of the pictures in them, so
/// that what the decoder loses is noticed and the others keep their numbers.
class VideoDemuxer {
 public:
  struct FormatDeleter {
    void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  };
  using FormatContext = std::unique_ptr<AVFormatContext, FormatDeleter>;

  /// @throws Error (kBadInput) as OpenVideo.
  explicit VideoDemuxer(const std::filesystem::path& path);

  const AVStream& stream() const { return *stream_; }
  const ffmpeg::Orientation& orientation() const { return orientation_; }

  /// Pictures found in the file so far.
  std::int64_t packets() const { return packets_; }

  /// The next packet, or null at the end of what can be read. AV_PKT_FLAG_CORRUPT marks those cut
  /// short.
  ffmpeg::Packet Next();

  /// The earliest time stamp of the pictures that have not been passed, or `otherwise`.
  std::int64_t Earliest(std::int64_t otherwise) const {
    return pending_.empty() ? otherwise : pending_.begin()->first;
  }

  struct Passed {
    std::int64_t lost = 0;   ///< Pictures between it and the one passed before.
    std::int64_t group = 0;  ///< Of the picture: the key frame before it and what follows on that.
    bool lost_reference = false;  ///< Whether it may refer to a lost one.
  };

  /// Takes note that the decoder gave the picture with this time stamp. Pictures come out in the
  /// order of their time stamps, so those before it that did not are lost.
  Passed Pass(std::int64_t pts);

  /// Pictures given out and not passed.
  std::int64_t pending() const { return static_cast<std::int64_t>(pending_.size()); }

 private:
  void ReadAhead();

  FormatContext format_;
  AVStream* stream_;
  ffmpeg::Orientation orientation_;
  std::deque<ffmpeg::Packet> ahead_;
  struct Place {
    std::int64_t group;
    std::int64_t key_pts;  ///< Of the group's key frame.
  };
  std::map<std::int64_t, Place> pending_;  ///< By time stamp.
  Place place_{0, 0};                      ///< Of the packet read last.
  std::int64_t packets_ = 0;
  bool at_end_of_file_ = false;
};

}  // namespace livemvs
