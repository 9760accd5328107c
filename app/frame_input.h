#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/io/frame_source.h"

namespace livemvs::app {

/// Pictures without poses: a video, a folder of images, or a folder with video.* or images/ inside.
struct FrameInput {
  std::filesystem::path path;    ///< The video or the folder of images.
  std::filesystem::path folder;  ///< Where a calibration beside it would be.
  bool video = false;

  std::unique_ptr<FrameSource> Open() const;
};

/// @throws Error (kBadInput) naming the path and what is expected.
FrameInput FindFrames(const std::filesystem::path& data);

/// The camera that `--camera` states: a file, numbers, "self" (none: the tracker finds it), or
/// where nothing is stated the calibration beside the pictures, if there is one. Says which.
std::optional<Camera> CameraFor(const std::string& stated, const FrameInput& input);

}  // namespace livemvs::app
