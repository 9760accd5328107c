#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/pipeline/reconstructor.h"
#include "livemvs/scan/tracking_stage.h"
#include "livemvs/stream/messages.h"
#include "livemvs/stream/record_sink.h"
#include "livemvs/stream/replay.h"

namespace livemvs {

struct ScanSettings {
  Options method;  ///< With search settled.
  SceneRange range;
  TrackingStageOptions stages;
};

/// How a scan goes, for those who watch.
struct ScanProgress {
  std::int64_t frames = 0;  ///< That the seeds saw, or had no pose.
  double frames_per_second = 0;
  TrackingState tracking = TrackingState::kSearching;
  std::string problem;  ///< Of tracking.
  std::int64_t live_seeds = 0;
  std::int64_t points = 0;
  std::int64_t dropped = 0;
};

enum class ScanEnd {
  kFinished,     ///< The source came to its end.
  kSourceLost,   ///< No picture came any more.
  kInterrupted,  ///< The user said so.
  kFailed,       ///< `failure` says why; what was reconstructed is kept.
};

struct ScanResult {
  ScanEnd end = ScanEnd::kFinished;
  std::exception_ptr failure;
  PointCloud points;
  std::vector<FrameMessage> frames;  ///< All, those before the resumption among them.
  std::optional<Camera> camera;      ///< As it was known at last.
  ReconstructionStatistics reconstruction;
  CaptureStatistics capture;
  std::string tracking_problem;  ///< The latest, for people.
  std::size_t live_seeds = 0;
  std::string backend;
  double seconds = 0;
};

/// One scan: pictures from a source, poses, seeds, and a stream of records of all that happens.
/// Capture, tracking, seeds and whatever the sinks do run side by side, with bounded queues between
/// them. Frames without a good pose never touch the seeds.
class Scan {
 public:
  /// @param source, poses  Must outlive the scan.
  /// @throws std::invalid_argument naming the option that is out of its range.
  Scan(const ScanSettings& settings, LiveSource* source, PoseSource* poses);

  /// Goes on where a scan stopped: its points cover what they cover, ids follow. Frames that it
  /// has seen already may come again, so that seeds grow where others were lost; they are not
  /// recorded anew.
  void Continue(const Replay& before);

  /// Records go to `sink`, which must outlive the scan, too.
  void AddSink(RecordSink* sink) { sinks_.push_back(sink); }

  struct Watch {
    std::function<bool()> stop;                         ///< Asked often; true ends the scan.
    std::function<std::exception_ptr()> broken;         ///< Likewise; an exception does too.
    std::function<void(const ScanProgress&)> progress;  ///< Told after each frame.
    std::function<void(const std::string&, bool warning)> news;
    /// Told of each frame that the seeds saw, and the points that converged in it; quick.
    std::function<void(const PosedFrame&, std::span<const Point>, const Reconstructor&)> seen;
    /// Told of each frame whose camera is not known, so that nothing comes of it; quick.
    std::function<void(const SourceFrame&)> missed;
  };
  /// Runs to the end. Failures on the way end it, and are returned with what is there.
  ScanResult Run(const Watch& watch);

 private:
  using Clock = std::chrono::steady_clock;

  void Write(RecordType type, const std::vector<std::uint8_t>& payload);
  void Loop(TrackingStage* stage, const Watch& watch);
  void Process(TrackedFrame tracked, const Watch& watch);
  void WriteFrame(const SourceFrame& frame, const PoseEstimate& pose);
  void WritePoints(std::int64_t frame, std::span<const Point> points);
  void WriteStatistics(const CaptureStatistics& capture);
  void WriteEnd();
  ScanProgress Progress(const CaptureStatistics& capture) const;

  ScanSettings settings_;
  LiveSource* source_;
  PoseSource* poses_;
  Reconstructor reconstructor_;
  std::vector<RecordSink*> sinks_;
  std::uint32_t next_id_ = 0;
  ScanResult result_;
  std::int64_t frames_ = 0;              ///< In this session.
  std::int64_t last_index_before_ = -1;  ///< Of the frames of earlier sessions.
  PoseEstimate last_pose_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point statistics_written_ = start_;
};

}  // namespace livemvs
