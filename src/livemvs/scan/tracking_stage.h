#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "livemvs/io/bounded_queue.h"
#include "livemvs/io/capture_queue.h"
#include "livemvs/scan/frame_gate.h"
#include "livemvs/tracking/pose_source.h"

namespace livemvs {

/// Whether a pose is one: finite, and its rotation a rotation.
bool IsRigid(const Rigid3d& pose);

/// A picture with what is known of its camera, or news of the source.
struct TrackedFrame {
  std::optional<SourceFrame> frame;
  PoseEstimate pose;
  Camera camera;
  std::string news;  ///< For people: "no picture comes".
  bool warning = false;
};

/// What became of the pictures before the seeds saw them.
struct CaptureStatistics {
  std::int64_t tracked = 0;       ///< With a pose.
  std::int64_t untracked = 0;     ///< Without.
  std::int64_t bad_poses = 0;     ///< Of those, with a pose that was none.
  std::int64_t out_of_order = 0;  ///< Left out.
  std::int64_t duplicates = 0;    ///< Left out.
  std::int64_t other_size = 0;    ///< Left out.
  std::int64_t dropped = 0;       ///< Left out, because the engine was late.
  std::int64_t damaged = 0;       ///< Lost by the decoder.
  double track_seconds = 0;       ///< Spent by the pose source.
};

struct TrackingStageOptions {
  CaptureOptions capture;
  std::size_t depth = 4;   ///< Most frames that wait for the seeds.
  double time_offset = 0;  ///< Added to time stamps: when a scan is resumed. [s]
  std::int64_t index_offset = 0;
  /// Without a picture for so long, the source has ended. [s]
  double patience = 10;
};

/// Takes pictures from a source, leaves out those that would do harm, and asks the pose source for
/// the poses of the others, on a thread of its own.
class TrackingStage {
 public:
  /// @param source, poses  Must outlive the stage, and are its alone meanwhile.
  TrackingStage(LiveSource* source, PoseSource* poses, const TrackingStageOptions& options);
  ~TrackingStage();
  TrackingStage(const TrackingStage&) = delete;
  TrackingStage& operator=(const TrackingStage&) = delete;

  /// The next frame; nothing where none comes in time, or ever again.
  /// @throws what the source threw, after the frames before it.
  std::optional<TrackedFrame> Next(std::chrono::milliseconds timeout);
  bool finished() const { return queue_.finished(); }
  /// Whether it ended because no picture came any more.
  bool source_lost() const { return source_lost_; }

  /// Takes no more pictures; those on the way are dropped.
  void Stop();

  CaptureStatistics statistics();

 private:
  void Run();
  bool HandleFrame(SourceFrame frame);
  bool Tell(std::string news, bool warning);
  PoseEstimate Estimate(const SourceFrame& frame);

  PoseSource* poses_;
  TrackingStageOptions options_;
  CaptureQueue capture_;
  BoundedQueue<TrackedFrame> queue_;
  FrameGate gate_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> source_lost_ = false;
  std::mutex mutex_;
  CaptureStatistics statistics_;
  std::exception_ptr failure_;
  bool lost_ = false;
  std::thread thread_;
};

}  // namespace livemvs
