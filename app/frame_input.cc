#include "frame_input.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/calibration.h"
#include "livemvs/io/image_source.h"
#include "livemvs/io/video_source.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> VideosIn(const fs::path& folder) {
  std::vector<fs::path> videos;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && HasVideoExtension(entry.path())) videos.push_back(entry.path());
  }
  std::sort(videos.begin(), videos.end());
  return videos;
}

FrameInput InFolder(const fs::path& folder) {
  const std::vector<fs::path> videos = VideosIn(folder);
  if (videos.size() == 1) return {videos.front(), folder, true};
  if (videos.size() > 1) {
    throw BadInput(folder.string() + ": holds " + std::to_string(videos.size()) +
                   " videos; name one of them");
  }
  for (const char* below : {"", "images", "rgb"}) {
    const fs::path images = *below == '\0' ? folder : folder / below;
    std::error_code error;
    if (fs::is_directory(images, error) && !ListImages(images).empty()) {
      return {images, folder, false};
    }
  }
  throw BadInput(folder.string() + ": neither a video nor images in it");
}

}  // namespace

std::unique_ptr<FrameSource> FrameInput::Open() const {
  return video ? OpenVideo(path) : OpenImages(ListImages(path));
}

FrameInput FindFrames(const fs::path& data) {
  std::error_code error;
  if (fs::is_directory(data, error)) return InFolder(data);
  if (!fs::exists(data, error)) {
    throw BadInput(data.string() +
                   ": there is no such file or folder; name a video or a folder of images");
  }
  return {data, data.has_parent_path() ? data.parent_path() : fs::path("."), true};
}

std::optional<Camera> CameraFor(const std::string& stated, const FrameInput& input) {
  if (stated == "self") return std::nullopt;
  if (!stated.empty()) return ReadCamera(stated);
  const auto found = FindCalibration(input.folder);
  if (!found) return std::nullopt;
  LogInfo("using the calibration " + found->string() +
          " (state \"self\" to find it from the board)");
  return ReadCamera(found->string());
}

}  // namespace livemvs::app
