#pragma once

#include <filesystem>
#include <memory>

#include "livemvs/io/dataset.h"

namespace livemvs {

/// A video file with poses and a calibration: `options.poses` and `options.camera`, or the files of
/// usual names beside the video. Poses with time stamps are looked up at each frame's own time in
/// seconds since the first frame; the others belong to frames by number.
/// @throws Error (kBadInput) naming file, place and remedy.
std::unique_ptr<Dataset> OpenPosedVideo(const std::filesystem::path& video,
                                        const DatasetOptions& options);

/// As OpenPosedVideo, for the images of a folder in their natural order. Poses with time stamps are
/// taken in order where they are as many as images, else by the images' names where these are
/// times.
/// @param base  Where pose file and calibration are looked for.
std::unique_ptr<Dataset> OpenPosedImages(const std::filesystem::path& base,
                                         const std::filesystem::path& images,
                                         const DatasetOptions& options);

}  // namespace livemvs
