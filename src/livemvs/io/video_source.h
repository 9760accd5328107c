#pragma once

#include <filesystem>
#include <memory>

#include "livemvs/io/frame_source.h"

namespace livemvs {

struct VideoSourceOptions {
  int threads = 2;  ///< Of the decoder; frames come out in the same order for any number.
  /// Hand out the frames between a damaged one and the next key frame too. They build on what was
  /// lost, and usually show ghosts of it.
  bool keep_suspect_frames = false;
};

/// Opens a video file: H.264, HEVC, VP8, VP9, AV1, MPEG-4 or Motion JPEG in MP4, MOV, MKV, WebM or
/// AVI. Luma is taken from the decoder as it is; the rotation that phones write is applied. Time
/// stamps are the container's, so that variable frame rates keep their meaning. A frame that the
/// decoder lost or knows to be damaged is passed over and counted, and so are those that build on
/// it, up to the next key frame; `SourceFrame::index` still counts them. A file that ends early
/// gives the frames that are there.
/// @throws Error (kBadInput) naming the file and the remedy, where it is missing, empty, no video,
/// of another kind, or cut before its index was written.
std::unique_ptr<FrameSource> OpenVideo(const std::filesystem::path& path,
                                       const VideoSourceOptions& options = {});

/// Whether the name ends as one of the containers that OpenVideo reads (.mp4, .mov, .m4v, .mkv,
/// .webm, .avi), in any case.
bool HasVideoExtension(const std::filesystem::path& path);

}  // namespace livemvs
