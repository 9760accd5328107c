#pragma once

/// What a file is before FFmpeg sees it. Private to io/.

#include <filesystem>
#include <string>

namespace livemvs {

/// FFmpeg's name of the demuxer for a video file ("mov", "matroska", "avi"), by the file's first
/// bytes.
/// @throws Error (kBadInput) where the file is missing, a directory, unreadable, empty, or none of
/// these.
std::string DemuxerOf(const std::filesystem::path& path);

/// Whether an MP4 or MOV file lacks its index (the moov atom): a recording that was cut off.
bool LacksMp4Index(const std::filesystem::path& path);

}  // namespace livemvs
