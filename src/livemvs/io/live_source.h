#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "livemvs/io/frame_source.h"

namespace livemvs {

/// Pictures as they come: from a camera, from a pipe, or from a recording that is played back. Not
/// thread-safe, but for Cancel().
class LiveSource {
 public:
  enum class Status {
    kFrame,
    kNothingYet,  ///< Ask again.
    kLost,        ///< The camera or writer has gone; ask again, it may come back.
    kEnded,       ///< There will be no more.
  };
  struct Answer {
    Status status = Status::kNothingYet;
    SourceFrame frame;    ///< Of kFrame. Its time is that of capture [s] since the first picture.
    std::string problem;  ///< Of kLost, for people.
  };

  virtual ~LiveSource() = default;

  virtual FrameSource::Info info() const = 0;
  virtual FrameSource::Statistics statistics() const = 0;

  /// Waits for the next picture. May take as long as nothing comes.
  /// @throws Error where it makes no sense to ask again.
  virtual Answer Next() = 0;

  /// Makes Next(), now and from now on, return within about 0.1 s. From any thread.
  virtual void Cancel() = 0;
};

struct PlaybackOptions {
  /// At the pace at which it was filmed, by its time stamps; otherwise as fast as it is taken.
  bool realtime = false;
  std::int64_t first_frame = 0;  ///< Frames before it are passed over.
  std::int64_t last_frame = -1;  ///< Last frame to hand out; -1: all.
  std::int64_t step = 1;         ///< Hand out every step-th.
};

/// Plays a recording.
std::unique_ptr<LiveSource> PlayBack(std::unique_ptr<FrameSource> recording,
                                     const PlaybackOptions& options);

}  // namespace livemvs
