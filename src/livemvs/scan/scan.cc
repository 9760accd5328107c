#include "livemvs/scan/scan.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "livemvs/stream/point_codec.h"

namespace livemvs {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kSlice{100};
constexpr milliseconds kStatisticsEvery{500};

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool Same(const Camera& a, const Camera& b) {
  return a.model == b.model && a.width == b.width && a.height == b.height && a.fx == b.fx &&
         a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.distortion == b.distortion;
}

EndMessage::Reason ReasonOf(ScanEnd end) {
  switch (end) {
    case ScanEnd::kInterrupted:
    case ScanEnd::kSourceLost:  // it may be gone on with
      return EndMessage::kInterrupted;
    case ScanEnd::kFailed:
      return EndMessage::kFailed;
    default:
      return EndMessage::kFinished;
  }
}

std::string TextOf(const std::exception_ptr& failure) {
  if (failure == nullptr) return "";
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "unknown failure";
  }
}

}  // namespace

Scan::Scan(const ScanSettings& settings, LiveSource* source, PoseSource* poses)
    : settings_(settings),
      source_(source),
      poses_(poses),
      reconstructor_(settings.method, settings.range) {}

void Scan::Continue(const Replay& before) {
  result_.frames = before.frames();
  result_.camera = before.camera();
  next_id_ = before.next_id();
  for (const FrameMessage& frame : before.frames()) {
    last_index_before_ = std::max(last_index_before_, frame.index);
  }
  reconstructor_.Restore(before.Points());
}

void Scan::Write(RecordType type, const std::vector<std::uint8_t>& payload) {
  for (RecordSink* sink : sinks_) sink->Write(type, payload);
}

ScanResult Scan::Run(const Watch& watch) {
  start_ = statistics_written_ = Clock::now();
  Write(
      RecordType::kScene,
      Encode(SceneMessage{
          settings_.range.box, settings_.range.near, settings_.range.far, settings_.range.origin}));
  TrackingStage stage(source_, poses_, settings_.stages);
  try {
    Loop(&stage, watch);
  } catch (...) {
    result_.failure = std::current_exception();
    result_.end = ScanEnd::kFailed;
  }
  stage.Stop();
  result_.capture = stage.statistics();
  result_.seconds = SecondsSince(start_);
  WriteStatistics(result_.capture);
  WriteEnd();
  result_.reconstruction = reconstructor_.statistics();
  result_.live_seeds = reconstructor_.live_seeds();
  result_.backend = reconstructor_.backend_name();
  result_.points = reconstructor_.TakePoints();
  return std::move(result_);
}

void Scan::Loop(TrackingStage* stage, const Watch& watch) {
  while (true) {
    if (watch.stop && watch.stop()) {
      result_.end = ScanEnd::kInterrupted;
      return;
    }
    if (watch.broken) {
      if (const std::exception_ptr broken = watch.broken()) std::rethrow_exception(broken);
    }
    std::optional<TrackedFrame> tracked = stage->Next(kSlice);
    if (!tracked && stage->finished()) {
      result_.end = stage->source_lost() ? ScanEnd::kSourceLost : ScanEnd::kFinished;
      return;
    }
    if (tracked && tracked->frame) {
      Process(*std::move(tracked), watch);
    } else if (tracked) {
      const MessageLevel level = tracked->warning ? MessageLevel::kWarning : MessageLevel::kInfo;
      Write(RecordType::kMessage, Encode(TextMessage{level, tracked->news}));
      if (watch.news) watch.news(tracked->news, tracked->warning);
    }
    const CaptureStatistics capture = stage->statistics();
    if (watch.progress) watch.progress(Progress(capture));
    if (Clock::now() - statistics_written_ >= kStatisticsEvery) WriteStatistics(capture);
  }
}

void Scan::Process(TrackedFrame tracked, const Watch& watch) {
  ++frames_;
  last_pose_ = tracked.pose;
  if (!last_pose_.problem.empty()) result_.tracking_problem = last_pose_.problem;
  // A tracker that calibrates itself knows no intrinsics at first.
  const bool known = tracked.camera.fx != 0;
  if (known && !(result_.camera && Same(*result_.camera, tracked.camera))) {
    result_.camera = tracked.camera;
    Write(RecordType::kCamera, Encode(tracked.camera));
  }
  const SourceFrame& frame = *tracked.frame;
  // The intrinsics of another picture size say nothing about this one.
  if (frame.picture->width() != tracked.camera.width ||
      frame.picture->height() != tracked.camera.height) {
    tracked.pose.cam_from_world.reset();
  }
  if (frame.index > last_index_before_) WriteFrame(frame, tracked.pose);
  if (!tracked.pose.cam_from_world) {
    if (watch.missed) watch.missed(frame);
    return;
  }
  PosedFrame posed;
  posed.index = frame.index;
  posed.timestamp = frame.timestamp;
  posed.name = frame.name;
  posed.picture = frame.picture;
  posed.camera = tracked.camera;
  posed.cam_from_world = *tracked.pose.cam_from_world;
  const std::span<const Point> converged = reconstructor_.AddFrame(posed);
  WritePoints(frame.index, converged);
  if (watch.seen) watch.seen(posed, converged, reconstructor_);
}

void Scan::WriteFrame(const SourceFrame& frame, const PoseEstimate& pose) {
  FrameMessage message;
  message.index = frame.index;
  message.timestamp = frame.timestamp;
  message.tracking_state = static_cast<std::uint8_t>(pose.state);
  message.cam_from_world = pose.cam_from_world;
  message.observations = static_cast<std::uint32_t>(std::max(0, pose.observations));
  message.rms_px = static_cast<float>(pose.rms_px);
  message.blur_px = static_cast<float>(pose.blur_px);
  Write(RecordType::kFrame, Encode(message));
  result_.frames.push_back(message);
}

void Scan::WritePoints(std::int64_t frame, std::span<const Point> points) {
  if (sinks_.empty()) return;
  for (const PointCloud& group : GroupForStream(points)) {
    Write(RecordType::kPoints, EncodePoints(frame, next_id_, group));
    next_id_ += static_cast<std::uint32_t>(group.size());
  }
}

void Scan::WriteStatistics(const CaptureStatistics& capture) {
  statistics_written_ = Clock::now();
  const ScanProgress progress = Progress(capture);
  const nlohmann::json json = {{"elapsed_s", SecondsSince(start_)},
                               {"frames", progress.frames},
                               {"frames_per_second", progress.frames_per_second},
                               {"frames_tracked", capture.tracked},
                               {"frames_untracked", capture.untracked},
                               {"frames_dropped", capture.dropped},
                               {"frames_out_of_order", capture.out_of_order},
                               {"frames_duplicated", capture.duplicates},
                               {"frames_damaged", capture.damaged},
                               {"bad_poses", capture.bad_poses},
                               {"seeds", progress.live_seeds},
                               {"points", progress.points},
                               {"tracking_problem", progress.problem}};
  // What a tracker says may not be UTF-8.
  Write(RecordType::kStatistics,
        EncodeStatistics(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)));
}

void Scan::WriteEnd() {
  EndMessage end;
  end.reason = ReasonOf(result_.end);
  end.frames = static_cast<std::int64_t>(result_.frames.size());
  end.points = static_cast<std::int64_t>(reconstructor_.points().size());
  end.text = TextOf(result_.failure);
  Write(RecordType::kEnd, Encode(end));
}

ScanProgress Scan::Progress(const CaptureStatistics& capture) const {
  ScanProgress progress;
  progress.frames = frames_;
  const double seconds = SecondsSince(start_);
  progress.frames_per_second = seconds > 0 ? static_cast<double>(frames_) / seconds : 0;
  progress.tracking = last_pose_.state;
  progress.problem = last_pose_.problem;
  progress.live_seeds = static_cast<std::int64_t>(reconstructor_.live_seeds());
  progress.points = static_cast<std::int64_t>(reconstructor_.points().size());
  progress.dropped = capture.dropped;
  return progress;
}

}  // namespace livemvs
