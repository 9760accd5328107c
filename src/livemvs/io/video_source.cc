#include "livemvs/io/video_source.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/frame_convert.h"
#include "livemvs/io/lower_case.h"
#include "livemvs/io/video_demuxer.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

ffmpeg::CodecContext OpenDecoder(const fs::path& path,
                                 const AVStream& stream,
                                 const VideoSourceOptions& options) {
  const AVCodec* codec = avcodec_find_decoder(stream.codecpar->codec_id);
  if (codec == nullptr) {
    throw Error(ErrorKind::kFailed,
                path.string() + ": this FFmpeg was built without a decoder for " +
                    avcodec_get_name(stream.codecpar->codec_id));
  }
  ffmpeg::CodecContext decoder = ffmpeg::MakeCodecContext(codec);
  int result = avcodec_parameters_to_context(decoder.get(), stream.codecpar);
  decoder->pkt_timebase = stream.time_base;
  decoder->thread_count = std::max(1, options.threads);
  decoder->thread_type = FF_THREAD_FRAME | FF_THREAD_SLICE;
  decoder->max_pixels = ffmpeg::kMaxPixels;
  // A picture with errors is reported at once, not concealed: with frame threading, the flags of a
  // concealed one are set too late to be seen.
  if (!options.keep_suspect_frames) decoder->err_recognition |= AV_EF_EXPLODE;
  if (result >= 0) result = avcodec_open2(decoder.get(), codec, nullptr);
  if (result < 0) {
    throw BadInput(path.string() + ": its " + codec->name + " stream cannot be decoded (" +
                   ffmpeg::ErrorText(result) + ")");
  }
  return decoder;
}

std::string CodecTitle(AVCodecID id) {
  const AVCodecDescriptor* descriptor = avcodec_descriptor_get(id);
  switch (id) {
    case AV_CODEC_ID_H264:
      return "H.264";
    case AV_CODEC_ID_MJPEG:
      return "Motion JPEG";
    case AV_CODEC_ID_MPEG4:
      return "MPEG-4";
    default: {
      std::string name = descriptor ? descriptor->name : "unknown";
      for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      return name;
    }
  }
}

std::string Rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

class VideoSource final : public FrameSource {
 public:
  VideoSource(const fs::path& path, const VideoSourceOptions& options);

  Info info() const override { return info_; }
  Statistics statistics() const override { return statistics_; }
  std::optional<SourceFrame> Next() override;

 private:
  bool SendNextPacket();
  bool IsGood(const AVFrame& frame);
  std::optional<SourceFrame> Accept(const AVFrame& frame);
  SourceFrame MakeSourceFrame(const AVFrame& frame, std::int64_t index);
  void Finish();

  fs::path path_;
  VideoSourceOptions options_;
  VideoDemuxer demuxer_;
  const AVStream* stream_;
  ffmpeg::CodecContext decoder_;
  ffmpeg::FrameConverter converter_;
  ffmpeg::Frame frame_ = ffmpeg::MakeFrame();
  Info info_;
  Statistics statistics_;

  std::int64_t next_index_ = 0;  ///< Of the next picture.
  std::optional<std::int64_t> start_pts_;
  std::optional<std::int64_t> last_pts_;
  double last_timestamp_ = -1;
  bool damage_seen_ = false;
  std::int64_t suspect_group_ = -1;  ///< The latest in which a picture was lost to damage.
  bool size_changed_ = false;
  bool finished_ = false;
};

VideoSource::VideoSource(const fs::path& path, const VideoSourceOptions& options)
    : path_(path),
      options_(options),
      demuxer_(path),
      stream_(&demuxer_.stream()),
      decoder_(OpenDecoder(path, *stream_, options)),
      converter_(demuxer_.orientation()) {
  info_.width = stream_->codecpar->width;
  info_.height = stream_->codecpar->height;
  if (demuxer_.orientation().transpose) std::swap(info_.width, info_.height);
  info_.frame_count = std::max<std::int64_t>(0, stream_->nb_frames);
  AVRational rate = stream_->avg_frame_rate;
  if (rate.num <= 0 || rate.den <= 0) rate = stream_->r_frame_rate;
  if (rate.num > 0 && rate.den > 0) info_.frames_per_second = av_q2d(rate);
  info_.description = CodecTitle(stream_->codecpar->codec_id) + " video " +
                      std::to_string(info_.width) + " x " + std::to_string(info_.height);
  if (info_.frames_per_second > 0) {
    info_.description += ", " + Rounded(info_.frames_per_second) + " Hz";
  }
  if (info_.frame_count > 0) {
    info_.description += ", " + std::to_string(info_.frame_count) + " frames";
  }
}

std::optional<SourceFrame> VideoSource::Next() {
  while (!finished_) {
    const int result = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (result == 0) {
      if (!IsGood(*frame_)) continue;
      if (auto frame = Accept(*frame_)) return frame;
    } else if (result == AVERROR_EOF) {
      Finish();
    } else if (result == AVERROR(ENOMEM)) {
      throw Error(ErrorKind::kOutOfResource, path_.string() + ": out of memory while decoding");
    } else if (result == AVERROR(EAGAIN)) {
      if (!SendNextPacket()) avcodec_send_packet(decoder_.get(), nullptr);
    } else {
      damage_seen_ = true;  // A lost picture: go on.
    }
  }
  return std::nullopt;
}

/// Gives the decoder its next packet; false at the end of the file.
bool VideoSource::SendNextPacket() {
  const ffmpeg::Packet packet = demuxer_.Next();
  if (!packet) return false;
  // What was cut short would decode to a picture that is grey in its lower part.
  if ((packet->flags & AV_PKT_FLAG_CORRUPT) ||
      avcodec_send_packet(decoder_.get(), packet.get()) < 0) {
    damage_seen_ = true;
  }
  return true;
}

bool VideoSource::IsGood(const AVFrame& frame) {
  if ((frame.flags & AV_FRAME_FLAG_CORRUPT) || frame.decode_error_flags != 0) {
    damage_seen_ = true;
    return false;
  }
  if (frame.width != stream_->codecpar->width || frame.height != stream_->codecpar->height) {
    size_changed_ = true;
    return false;
  }
  // Pictures out of order cannot be numbered.
  return frame.pts == AV_NOPTS_VALUE || !last_pts_ || frame.pts > *last_pts_;
}

/// Numbers the frame; nothing where it refers to damaged ones.
std::optional<SourceFrame> VideoSource::Accept(const AVFrame& frame) {
  if (frame.pts == AV_NOPTS_VALUE) return MakeSourceFrame(frame, next_index_++);
  if (!start_pts_) start_pts_ = std::min(frame.pts, demuxer_.Earliest(frame.pts));
  last_pts_ = frame.pts;
  const VideoDemuxer::Passed passed = demuxer_.Pass(frame.pts);
  statistics_.skipped += passed.lost;
  next_index_ += passed.lost;
  const std::int64_t index = next_index_++;
  // Without damage, what the decoder leaves out is not referred to.
  if (passed.lost_reference && damage_seen_) suspect_group_ = passed.group;
  if (suspect_group_ == passed.group && !options_.keep_suspect_frames) {
    ++statistics_.skipped;
    return std::nullopt;
  }
  return MakeSourceFrame(frame, index);
}

SourceFrame VideoSource::MakeSourceFrame(const AVFrame& frame, std::int64_t index) {
  SourceFrame result;
  result.index = index;
  result.name = "frame " + std::to_string(result.index);
  const double rate = info_.frames_per_second > 0 ? info_.frames_per_second : 30;
  result.timestamp = frame.pts != AV_NOPTS_VALUE
                         ? static_cast<double>(frame.pts - *start_pts_) * av_q2d(stream_->time_base)
                         : static_cast<double>(result.index) / rate;
  if (result.timestamp <= last_timestamp_) result.timestamp = last_timestamp_ + 1 / rate;
  last_timestamp_ = result.timestamp;
  result.picture = std::make_shared<const Picture>(converter_.Convert(frame));
  ++statistics_.decoded;
  return result;
}

void VideoSource::Finish() {
  finished_ = true;
  statistics_.skipped += demuxer_.pending();
  if (statistics_.decoded == 0) {
    throw BadInput(path_.string() +
                   ": not one of its frames can be decoded; copy or export the "
                   "video again");
  }
  if (demuxer_.packets() < info_.frame_count) {
    LogWarning(path_.string() + ": the file ends early, after " +
               std::to_string(demuxer_.packets()) + " of " + std::to_string(info_.frame_count) +
               " frames");
  }
  if (statistics_.skipped > 0) {
    LogWarning(path_.string() + ": " + std::to_string(statistics_.skipped) +
               " frames that are damaged, or build on damaged ones, were passed over, " +
               std::to_string(statistics_.decoded) + " are good" +
               (size_changed_ ? " (some had another picture size)" : ""));
  }
}

}  // namespace

std::unique_ptr<FrameSource> OpenVideo(const fs::path& path, const VideoSourceOptions& options) {
  return std::make_unique<VideoSource>(path, options);
}

bool HasVideoExtension(const fs::path& path) {
  const std::string ending = LowerExtension(path);
  for (const char* known : {".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi"}) {
    if (ending == known) return true;
  }
  return false;
}

}  // namespace livemvs
