#include "livemvs/scan/tracking_stage.h"

#include <Eigen/LU>
#include <cmath>
#include <new>
#include <utility>

namespace livemvs {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kCaptureSlice{100};

}  // namespace

bool IsRigid(const Rigid3d& pose) {
  constexpr double kTolerance = 1e-4;
  constexpr double kFarthest = 1e12;  // [scene]; a tracker that has lost its way knows no bounds
  const Eigen::Matrix3d residual =
      pose.rotation.transpose() * pose.rotation - Eigen::Matrix3d::Identity();
  // False for NaN.
  return residual.cwiseAbs().maxCoeff() <= kTolerance && residual.allFinite() &&
         pose.rotation.determinant() > 0 && pose.translation.allFinite() &&
         pose.translation.norm() <= kFarthest;
}

TrackingStage::TrackingStage(LiveSource* source,
                             PoseSource* poses,
                             const TrackingStageOptions& options)
    : poses_(poses),
      options_(options),
      capture_(source, options.capture),
      queue_(options.depth),
      thread_([this] { Run(); }) {}

TrackingStage::~TrackingStage() {
  Stop();
  thread_.join();
}

void TrackingStage::Stop() {
  stop_ = true;
  capture_.Stop();
  queue_.Close();
}

std::optional<TrackedFrame> TrackingStage::Next(std::chrono::milliseconds timeout) {
  std::optional<TrackedFrame> frame = queue_.Pop(timeout);
  if (!frame && queue_.finished()) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }
  return frame;
}

CaptureStatistics TrackingStage::statistics() {
  const std::int64_t dropped = capture_.dropped();
  const std::int64_t damaged = capture_.statistics().skipped;
  const std::lock_guard<std::mutex> lock(mutex_);
  CaptureStatistics statistics = statistics_;
  statistics.dropped = dropped;
  statistics.damaged = damaged;
  return statistics;
}

PoseEstimate TrackingStage::Estimate(const SourceFrame& frame) {
  const Clock::time_point start = Clock::now();
  PoseEstimate pose;
  bool bad = false;
  try {
    pose = poses_->Estimate(*frame.picture, frame.timestamp);
    bad = pose.cam_from_world && !IsRigid(*pose.cam_from_world);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    pose.problem = e.what();
    bad = true;
  }
  if (bad) {
    pose.cam_from_world.reset();
    pose.state = TrackingState::kLost;
    if (pose.problem.empty()) pose.problem = "the pose is not a number";
    pose.rms_px = pose.blur_px = 0;
  }
  if (!std::isfinite(pose.rms_px)) pose.rms_px = 0;
  if (!std::isfinite(pose.blur_px)) pose.blur_px = 0;
  const std::lock_guard<std::mutex> lock(mutex_);
  statistics_.bad_poses += bad ? 1 : 0;
  ++(pose.cam_from_world ? statistics_.tracked : statistics_.untracked);
  statistics_.track_seconds += std::chrono::duration<double>(Clock::now() - start).count();
  return pose;
}

bool TrackingStage::HandleFrame(SourceFrame frame) {
  frame.timestamp += options_.time_offset;
  frame.index += options_.index_offset;
  const FrameGate::Verdict verdict = gate_.Judge(frame);
  if (verdict != FrameGate::Verdict::kGood) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (verdict == FrameGate::Verdict::kOutOfOrder) ++statistics_.out_of_order;
    if (verdict == FrameGate::Verdict::kDuplicate) ++statistics_.duplicates;
    if (verdict == FrameGate::Verdict::kOtherSize) ++statistics_.other_size;
    return true;
  }
  TrackedFrame tracked;
  tracked.pose = Estimate(frame);
  tracked.camera = poses_->camera();
  tracked.frame = std::move(frame);
  return queue_.Push(std::move(tracked));
}

bool TrackingStage::Tell(std::string news, bool warning) {
  TrackedFrame tracked;
  tracked.news = std::move(news);
  tracked.warning = warning;
  return queue_.Push(std::move(tracked));
}

void TrackingStage::Run() {
  try {
    bool open = true;
    while (open && !stop_) {
      CaptureQueue::Item item = capture_.Next(kCaptureSlice);
      switch (item.event) {
        case CaptureQueue::Event::kFrame:
          if (std::exchange(lost_, false)) Tell("pictures come again", false);
          open = HandleFrame(std::move(item.frame));
          break;
        case CaptureQueue::Event::kLost:
          lost_ = true;
          open = Tell("camera lost: " + item.problem, true);
          break;
        case CaptureQueue::Event::kNothing:
          if (!lost_ || capture_.seconds_silent() < options_.patience) break;
          source_lost_ = true;
          open = false;
          break;
        case CaptureQueue::Event::kEnded:
          open = false;
          break;
      }
    }
  } catch (...) {
    const std::lock_guard<std::mutex> lock(mutex_);
    failure_ = std::current_exception();
  }
  queue_.Close();
}

}  // namespace livemvs
