#pragma once

/// What the tests of scans share: a filmed plane, played as a live source, with its poses.

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "livemvs/io/live_source.h"
#include "livemvs/scan/scan.h"
#include "livemvs/stream/record_sink.h"
#include "livemvs/tracking/pose_source.h"
#include "plane_scene.h"

namespace livemvs::testing_support {

inline constexpr double kFrameTime = 0.04;  ///< [s]

inline const std::vector<PosedFrame>& PlaneFrames() {
  static const auto* frames = new std::vector<PosedFrame>(PlaneScene().Render(SidewaysPath(60)));
  return *frames;
}

inline SourceFrame SourceFrameOf(const PosedFrame& posed) {
  SourceFrame frame;
  frame.index = posed.index;
  frame.timestamp = kFrameTime * static_cast<double>(posed.index);
  frame.name = posed.name;
  frame.picture = posed.picture;
  return frame;
}

/// Gives the answers of a script, one after the other, then the end.
class ScriptedSource final : public LiveSource {
 public:
  using Step = std::function<Answer()>;

  FrameSource::Info info() const override { return {}; }
  FrameSource::Statistics statistics() const override { return {}; }
  void Cancel() override {}
  Answer Next() override {
    if (next_ < steps.size()) return steps[next_++]();
    Answer end;
    end.status = Status::kEnded;
    return end;
  }

  void Add(const SourceFrame& frame) {
    steps.push_back([frame] {
      Answer answer;
      answer.status = Status::kFrame;
      answer.frame = frame;
      return answer;
    });
  }
  void AddFrames(std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) Add(SourceFrameOf(PlaneFrames()[i]));
  }

  std::vector<Step> steps;

 private:
  std::size_t next_ = 0;
};

/// The true poses, by time; or what a test puts in their place.
class TruePoses : public PoseSource {
 public:
  Camera camera() const override { return PlaneFrames()[0].camera; }
  PoseEstimate Estimate(const Picture& /*picture*/, double timestamp) override {
    const auto index = static_cast<std::size_t>(std::lround(timestamp / kFrameTime));
    PoseEstimate pose;
    pose.state = TrackingState::kTracking;
    pose.cam_from_world = PlaneFrames()[index].cam_from_world;
    pose.observations = 50;
    pose.rms_px = 0.1;
    if (spoil) spoil(index, &pose);
    return pose;
  }
  std::function<void(std::size_t index, PoseEstimate* pose)> spoil;
};

/// Keeps a stream in memory.
class MemorySink final : public RecordSink {
 public:
  void Write(RecordType type, std::span<const std::uint8_t> payload) override {
    Record record{type, count++, payload};
    replay.Apply(record);
    types.push_back(type);
  }
  Replay replay;
  std::vector<RecordType> types;
  std::uint32_t count = 0;
};

inline ScanSettings PlaneSettings() {
  ScanSettings settings;
  settings.method = TestOptions();
  settings.range.near = 0.6;
  settings.range.far = 1.8;
  settings.range.origin = "the test";
  return settings;
}

/// What the Reconstructor makes of these frames, without anything around it.
inline PointCloud PointsOf(const std::vector<std::size_t>& frames) {
  Reconstructor reconstructor(PlaneSettings().method, PlaneSettings().range);
  for (const std::size_t i : frames) reconstructor.AddFrame(PlaneFrames()[i]);
  return reconstructor.TakePoints();
}

inline std::vector<std::size_t> Indices(std::size_t first, std::size_t last) {
  std::vector<std::size_t> indices;
  for (std::size_t i = first; i < last; ++i) indices.push_back(i);
  return indices;
}

inline bool SamePositions(const PointCloud& a, const PointCloud& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].position != b[i].position) return false;
  }
  return true;
}

}  // namespace livemvs::testing_support
