#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "livemvs/core/frame.h"

namespace livemvs {

/// One picture of a video or image folder, not yet posed.
struct SourceFrame {
  std::int64_t index =
      0;                 ///< Position in the source, from 0; frames that were skipped are counted.
  double timestamp = 0;  ///< [s] since the first frame.
  std::string name;      ///< For messages: the file's name, or "frame 12".
  std::shared_ptr<const Picture> picture;
};

/// A video or a folder of images, read once from front to back. Not thread-safe.
class FrameSource {
 public:
  struct Info {
    int width = 0;                 ///< [px], after the rotation in the metadata.
    int height = 0;                ///< [px]
    std::int64_t frame_count = 0;  ///< As the container states it, or 0 where it does not.
    double frames_per_second = 0;  ///< Mean rate, or 0 where unknown.
    std::string description;       ///< For people: "H.264 video 960 x 720, 30 Hz, 240 frames".
  };
  struct Statistics {
    std::int64_t decoded = 0;  ///< Pictures handed out.
    std::int64_t skipped = 0;  ///< Pictures lost to damage.
  };

  virtual ~FrameSource() = default;

  virtual Info info() const = 0;
  virtual Statistics statistics() const = 0;

  /// The next good picture, or nothing at the end. Damaged stretches are passed over, counted, and
  /// reported once through LogWarning.
  /// @throws Error where nothing at all can be read.
  virtual std::optional<SourceFrame> Next() = 0;
};

}  // namespace livemvs
