#include "livemvs/io/video_demuxer.h"

extern "C" {
#include <libavutil/display.h>
}

#include <string>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/video_container.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

using FormatContext = VideoDemuxer::FormatContext;

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
  ffmpeg::Silence();
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

}  // namespace

VideoDemuxer::VideoDemuxer(const fs::path& path)
    : format_(OpenContainer(path)),
      stream_(FindVideoStream(path, format_.get())),
      orientation_(ReadOrientation(path, *stream_)) {}

void VideoDemuxer::ReadAhead() {
  constexpr int kMaxErrorsInARow = 100;
  int errors = 0;
  while (!at_end_of_file_) {
    ffmpeg::Packet packet = ffmpeg::MakePacket();
    const int result = av_read_frame(format_.get(), packet.get());
    if (result < 0) {
      at_end_of_file_ = result == AVERROR_EOF || ++errors == kMaxErrorsInARow;
      continue;
    }
    if (packet->stream_index != stream_->index) continue;
    ++packets_;
    if (packet->flags & AV_PKT_FLAG_KEY) place_ = {place_.group + 1, packet->pts};
    if (packet->size == 0) continue;  // AVI: show the picture before for longer.
    if (packet->pts != AV_NOPTS_VALUE && !IsHidden(*packet, stream_->codecpar->codec_id)) {
      pending_.emplace(packet->pts, place_);
    }
    ahead_.push_back(std::move(packet));
    return;
  }
}

ffmpeg::Packet VideoDemuxer::Next() {
  // No codec moves a picture further than this from its place in the file.
  constexpr std::size_t kReordering = 17;
  while (ahead_.size() < kReordering && !at_end_of_file_) ReadAhead();
  if (ahead_.empty()) return nullptr;
  ffmpeg::Packet packet = std::move(ahead_.front());
  ahead_.pop_front();
  return packet;
}

VideoDemuxer::Passed VideoDemuxer::Pass(std::int64_t pts) {
  Passed passed;
  const auto here = pending_.find(pts);
  if (here != pending_.end()) passed.group = here->second.group;
  while (!pending_.empty() && pending_.begin()->first < pts) {
    const auto& [lost_pts, lost] = *pending_.begin();
    // What is shown before its key frame is referred to by its like alone.
    passed.lost_reference |= lost.group == passed.group && lost_pts >= lost.key_pts;
    pending_.erase(pending_.begin());
    ++passed.lost;
  }
  pending_.erase(pts);
  return passed;
}

}  // namespace livemvs
