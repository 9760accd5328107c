#include "livemvs/io/video_source.h"

extern "C" {
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/ffmpeg_util.h"
#include "livemvs/io/frame_convert.h"
#include "livemvs/io/video_container.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

struct FormatDeleter {
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
};
using FormatContext = std::unique_ptr<AVFormatContext, FormatDeleter>;

constexpr const char* kDecoders = "h264,hevc,vp8,vp9,libdav1d,libaom-av1,av1,mpeg4,mjpeg";

bool IsSupported(AVCodecID id) {
  switch (id) {
    case AV_CODEC_ID_H264:
    case AV_CODEC_ID_HEVC:
    case AV_CODEC_ID_VP8:
    case AV_CODEC_ID_VP9:
    case AV_CODEC_ID_AV1:
    case AV_CODEC_ID_MPEG4:
    case AV_CODEC_ID_MJPEG:
      return true;
    default:
      return false;
  }
}

FormatContext OpenContainer(const fs::path& path) {
  const std::string demuxer = DemuxerOf(path);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", "mov,matroska,webm,avi", 0);
  av_dict_set(&options, "codec_whitelist", kDecoders, 0);
  AVFormatContext* raw = nullptr;
  const int result = avformat_open_input(
      &raw, ("file:" + path.string()).c_str(), av_find_input_format(demuxer.c_str()), &options);
  av_dict_free(&options);
  FormatContext format(raw);
  if (result >= 0) return format;
  if (demuxer == "mov" && LacksMp4Index(path)) {
    throw BadInput(path.string() +
                   ": the video was cut off before its index (moov atom) was written, so no frame "
                   "can be found; copy it again, repair it with a tool such as untrunc, or record "
                   "to MKV, which survives cuts");
  }
  throw BadInput(path.string() + ": damaged video file (" + ffmpeg::ErrorText(result) +
                 "); copy or export it again");
}

AVStream* FindVideoStream(const fs::path& path, AVFormatContext* format) {
  for (unsigned i = 0; i < format->nb_streams; ++i) {
    const bool is_video = format->streams[i]->codecpar->codec_type == AVMEDIA_TYPE_VIDEO;
    if (!is_video) format->streams[i]->discard = AVDISCARD_ALL;
  }
  avformat_find_stream_info(format, nullptr);  // What it cannot find out is checked below.
  const int index = av_find_best_stream(format, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0 || (format->streams[index]->disposition & AV_DISPOSITION_ATTACHED_PIC)) {
    throw BadInput(path.string() + ": holds no video stream");
  }
  for (unsigned i = 0; i < format->nb_streams; ++i) {
    if (static_cast<int>(i) != index) format->streams[i]->discard = AVDISCARD_ALL;
  }
  const AVCodecParameters& parameters = *format->streams[index]->codecpar;
  if (!IsSupported(parameters.codec_id)) {
    throw BadInput(path.string() + ": its codec " + avcodec_get_name(parameters.codec_id) +
                   " is not supported; convert it, for instance by: ffmpeg -i IN -c:v libx264 "
                   "-crf 18 OUT.mp4");
  }
  const std::int64_t pixels = std::int64_t{parameters.width} * parameters.height;
  if (parameters.width <= 0 || parameters.height <= 0 || parameters.width > ffmpeg::kMaxSide ||
      parameters.height > ffmpeg::kMaxSide || pixels > ffmpeg::kMaxPixels) {
    throw BadInput(path.string() + ": its picture size " + std::to_string(parameters.width) +
                   " x " + std::to_string(parameters.height) +
                   " is damaged or beyond 16384 x 16384");
  }
  return format->streams[index];
}

ffmpeg::CodecContext OpenDecoder(const fs::path& path, const AVStream& stream, int threads) {
  const AVCodec* codec = avcodec_find_decoder(stream.codecpar->codec_id);
  if (codec == nullptr) {
    throw Error(ErrorKind::kFailed,
                path.string() + ": this FFmpeg was built without a decoder for " +
                    avcodec_get_name(stream.codecpar->codec_id));
  }
  ffmpeg::CodecContext decoder = ffmpeg::MakeCodecContext(codec);
  int result = avcodec_parameters_to_context(decoder.get(), stream.codecpar);
  decoder->pkt_timebase = stream.time_base;
  decoder->thread_count = std::max(1, threads);
  decoder->thread_type = FF_THREAD_FRAME | FF_THREAD_SLICE;
  decoder->max_pixels = ffmpeg::kMaxPixels;
  if (result >= 0) result = avcodec_open2(decoder.get(), codec, nullptr);
  if (result < 0) {
    throw BadInput(path.string() + ": its " + codec->name + " stream cannot be decoded (" +
                   ffmpeg::ErrorText(result) + ")");
  }
  return decoder;
}

ffmpeg::Orientation ReadOrientation(const fs::path& path, const AVStream& stream) {
#if LIBAVFORMAT_VERSION_INT >= AV_VERSION_INT(60, 15, 100)
  const AVPacketSideData* data = av_packet_side_data_get(stream.codecpar->coded_side_data,
                                                         stream.codecpar->nb_coded_side_data,
                                                         AV_PKT_DATA_DISPLAYMATRIX);
  const std::uint8_t* matrix = data ? data->data : nullptr;
  const std::size_t size = data ? data->size : 0;
#else
  std::size_t size = 0;
  const std::uint8_t* matrix = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &size);
#endif
  ffmpeg::Orientation orientation;
  if (matrix == nullptr || size < 9 * sizeof(std::int32_t)) return orientation;
  if (!ffmpeg::OrientationFromMatrix(reinterpret_cast<const std::int32_t*>(matrix), &orientation)) {
    LogWarning(path.string() +
               ": its rotation metadata is no multiple of 90 degrees and is not applied");
  }
  return orientation;
}

/// VP8 stores pictures that are only references as packets of their own.
bool IsHidden(const AVPacket& packet, AVCodecID codec) {
  if (packet.flags & AV_PKT_FLAG_DISCARD) return true;
  return codec == AV_CODEC_ID_VP8 && packet.size > 0 && !(packet.data[0] & 0x10);
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
  std::int64_t IndexOf(std::int64_t pts);
  SourceFrame MakeSourceFrame(const AVFrame& frame);
  void Finish();

  fs::path path_;
  FormatContext format_;
  AVStream* stream_ = nullptr;
  ffmpeg::CodecContext decoder_;
  ffmpeg::FrameConverter converter_;
  ffmpeg::Packet packet_ = ffmpeg::MakePacket();
  ffmpeg::Frame frame_ = ffmpeg::MakeFrame();
  Info info_;
  Statistics statistics_;

  /// Time stamps of the pictures given to the decoder and not seen since. Pictures come out in the
  /// order of their time stamps, so what is earlier than the latest was lost.
  std::multiset<std::int64_t> pending_;
  std::int64_t packets_ = 0;     ///< Pictures found in the file.
  std::int64_t next_index_ = 0;  ///< Of the next picture.
  std::optional<std::int64_t> start_pts_;
  std::optional<std::int64_t> last_pts_;
  double last_timestamp_ = -1;
  bool size_changed_ = false;
  bool at_end_of_file_ = false;
  bool finished_ = false;
};

VideoSource::VideoSource(const fs::path& path, const VideoSourceOptions& options) : path_(path) {
  ffmpeg::Silence();
  format_ = OpenContainer(path);
  stream_ = FindVideoStream(path, format_.get());
  decoder_ = OpenDecoder(path, *stream_, options.threads);
  const ffmpeg::Orientation orientation = ReadOrientation(path, *stream_);
  converter_ = ffmpeg::FrameConverter(orientation);

  info_.width = stream_->codecpar->width;
  info_.height = stream_->codecpar->height;
  if (orientation.transpose) std::swap(info_.width, info_.height);
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
      if (IsGood(*frame_)) return MakeSourceFrame(*frame_);
    } else if (result == AVERROR_EOF) {
      Finish();
    } else if (result == AVERROR(ENOMEM)) {
      throw Error(ErrorKind::kOutOfResource, path_.string() + ": out of memory while decoding");
    } else if (result == AVERROR(EAGAIN) && !SendNextPacket()) {
      avcodec_send_packet(decoder_.get(), nullptr);  // Any other error: a lost picture, go on.
    }
  }
  return std::nullopt;
}

/// Gives the decoder its next packet; false at the end of the file.
bool VideoSource::SendNextPacket() {
  constexpr int kMaxErrorsInARow = 100;
  int errors = 0;
  while (!at_end_of_file_) {
    av_packet_unref(packet_.get());
    const int result = av_read_frame(format_.get(), packet_.get());
    if (result < 0) {
      at_end_of_file_ = result == AVERROR_EOF || ++errors == kMaxErrorsInARow;
      continue;
    }
    if (packet_->stream_index != stream_->index) continue;
    ++packets_;
    if (packet_->size == 0) continue;  // AVI: show the picture before for longer.
    if (packet_->pts != AV_NOPTS_VALUE && !IsHidden(*packet_, stream_->codecpar->codec_id)) {
      pending_.insert(packet_->pts);
    }
    // What was cut short would decode to a picture that is grey in its lower part.
    if (packet_->flags & AV_PKT_FLAG_CORRUPT) continue;
    avcodec_send_packet(decoder_.get(), packet_.get());  // Errors show as pictures that are lost.
    return true;
  }
  return false;
}

bool VideoSource::IsGood(const AVFrame& frame) {
  if ((frame.flags & AV_FRAME_FLAG_CORRUPT) || frame.decode_error_flags != 0) return false;
  if (frame.width != stream_->codecpar->width || frame.height != stream_->codecpar->height) {
    size_changed_ = true;
    return false;
  }
  // Pictures out of order cannot be numbered.
  return frame.pts == AV_NOPTS_VALUE || !last_pts_ || frame.pts > *last_pts_;
}

std::int64_t VideoSource::IndexOf(std::int64_t pts) {
  if (pts == AV_NOPTS_VALUE) return next_index_++;
  while (!pending_.empty() && *pending_.begin() < pts) {
    pending_.erase(pending_.begin());
    ++next_index_;
    ++statistics_.skipped;
  }
  if (!pending_.empty() && *pending_.begin() == pts) pending_.erase(pending_.begin());
  last_pts_ = pts;
  return next_index_++;
}

SourceFrame VideoSource::MakeSourceFrame(const AVFrame& frame) {
  if (!start_pts_ && frame.pts != AV_NOPTS_VALUE) {
    start_pts_ = pending_.empty() ? frame.pts : std::min(frame.pts, *pending_.begin());
  }
  SourceFrame result;
  result.index = IndexOf(frame.pts);
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
  statistics_.skipped += static_cast<std::int64_t>(pending_.size());
  if (statistics_.decoded == 0) {
    throw BadInput(path_.string() +
                   ": not one of its frames can be decoded; copy or export the "
                   "video again");
  }
  if (packets_ < info_.frame_count) {
    LogWarning(path_.string() + ": the file ends early, after " + std::to_string(packets_) +
               " of " + std::to_string(info_.frame_count) + " frames");
  }
  if (statistics_.skipped > 0) {
    LogWarning(path_.string() + ": " + std::to_string(statistics_.skipped) +
               " damaged frames were passed over, " + std::to_string(statistics_.decoded) +
               " are good" + (size_changed_ ? " (some had another picture size)" : ""));
  }
}

}  // namespace

std::unique_ptr<FrameSource> OpenVideo(const fs::path& path, const VideoSourceOptions& options) {
  return std::make_unique<VideoSource>(path, options);
}

bool HasVideoExtension(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* known : {".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi"}) {
    if (ending == known) return true;
  }
  return false;
}

}  // namespace livemvs
