#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/map/point_map.h"
#include "livemvs/pipeline/seed_pool.h"
#include "livemvs/stream/messages.h"
#include "viewer/preview.h"
#include "viewer/seed_marks.h"
#include "viewer/stream_log.h"

namespace livemvs::viewer {

struct FeedOptions {
  Options engine;            ///< Of the reconstruction: what seeds mean.
  double most_hz = 30;       ///< The stream is written at most so often [1/s].
  double preview_hz = 8;     ///< The camera's picture, likewise [1/s].
  int preview_width = 480;   ///< [px]
  bool records = true;       ///< Frames and points, too; false: somebody else writes them.
  std::size_t marks = 1500;  ///< Seeds and points marked on the picture.
  PointMapOptions map;
};

/// What the engine knows at a frame.
struct LiveCounts {
  std::int64_t frames = 0;
  std::int64_t frames_total = 0;  ///< 0: unknown.
  std::int64_t frames_dropped = 0;
  std::int64_t seeds = 0;
  std::int64_t points = 0;  ///< That converged, before the map merges them.
  std::string problem;      ///< Of tracking, for people; empty: none.
};

/// A picture that waits to be encoded. Private to the feed.
struct PendingPreview {
  PosedFrame frame;
  bool posed = true;
  std::vector<SeedMark> marks;
};

/// Turns what a reconstruction gives into the stream: points pass an octree map, which sends each
/// piece of surface once, and again when it is known better. The engine only hands over; the work
/// is done on a thread of the feed's own. Points are never lost; pictures are, when it is busy.
class Feed {
 public:
  /// @param log  Must outlive the feed.
  Feed(StreamLog* log, const FeedOptions& options);
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  void Begin(const SessionMessage& session, const std::optional<SceneMessage>& scene);
  /// Hands over a frame and the points that converged in it. To be called from one thread.
  /// @param pool  Live seeds, to be marked on the picture; may be nullptr.
  void AddFrame(const PosedFrame& frame,
                std::span<const Point> converged,
                const LiveCounts& counts,
                const SeedPool* pool);
  /// The picture of a frame that nothing is made of, because its camera is not known. Likewise.
  void AddPicture(std::int64_t index, std::shared_ptr<const Picture> picture);
  /// What is counted apart from frames that are handed over.
  void SetCounts(const LiveCounts& counts);
  void AddMessage(MessageLevel level, const std::string& text);
  /// "running", "paused", "lost", "writing", …: for the page.
  void SetState(const std::string& state);
  /// Sends all that waits, and the end. Nothing may follow.
  void End(const EndMessage& end);

  /// Points that the map holds.
  std::size_t map_points() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Pending {
    FrameMessage message;
    Camera camera;
    PointCloud points;
    double handed = 0;  // when [s since 1970]
  };

  void Run();
  bool PreviewIsDue();
  void SendFrame(const Pending& frame);
  void SendPoints(std::int64_t frame, const PointCloud& group);
  void SendPreview(PendingPreview preview);
  void SendLive(const LiveCounts& counts,
                const std::string& state,
                const std::deque<Pending>& frames);
  double MotionPx(const PosedFrame& frame);

  StreamLog* log_;
  FeedOptions options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Pending> frames_;
  std::optional<PendingPreview> preview_;
  LiveCounts counts_;
  std::string state_ = "running";
  bool live_changed_ = false;
  bool stop_ = false;
  std::size_t map_points_ = 0;
  Clock::time_point last_marked_{};  // of the engine's thread alone

  // Of the feed's thread alone.
  PointMap map_;
  PreviewEncoder encoder_;
  std::optional<Camera> sent_camera_;
  PointCloud recent_;  // points that converged lately, to be marked
  std::size_t recent_next_ = 0;
  std::optional<Rigid3d> last_pose_;
  std::int64_t last_frame_ = 0;
  double motion_px_ = 0;
  double sharpness_ = 0, usual_sharpness_ = 0;
  Clock::time_point last_preview_{}, start_ = Clock::now();
  std::thread thread_;
};

}  // namespace livemvs::viewer
