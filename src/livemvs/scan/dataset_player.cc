#include "livemvs/scan/dataset_player.h"

#include <algorithm>
#include <utility>

namespace livemvs {

class DatasetPlayer::Frames final : public FrameSource {
 public:
  explicit Frames(DatasetPlayer* player) : player_(player) {}

  Info info() const override {
    Info info;
    const auto& views = player_->dataset_->views();
    info.frame_count = static_cast<std::int64_t>(views.size());
    if (!views.empty()) {
      info.width = views[0].camera.width;
      info.height = views[0].camera.height;
    }
    info.description = player_->dataset_->description();
    return info;
  }
  Statistics statistics() const override {
    const Dataset::Statistics s = player_->dataset_->statistics();
    return {s.decoded, s.skipped};
  }
  std::optional<SourceFrame> Next() override { return player_->Next(); }

 private:
  DatasetPlayer* player_;
};

class DatasetPlayer::Poses final : public PoseSource {
 public:
  explicit Poses(DatasetPlayer* player) : player_(player) {
    if (!player->dataset_->views().empty()) camera_ = player->dataset_->views()[0].camera;
  }

  PoseEstimate Estimate(const Picture& picture, double /*timestamp*/) override {
    PoseEstimate estimate;
    const std::optional<Known> known = player_->Find(picture);
    if (!known) {
      estimate.state = TrackingState::kLost;
      estimate.problem = "no pose is given for this picture";
      return estimate;
    }
    camera_ = known->camera;
    estimate.state = TrackingState::kTracking;
    estimate.cam_from_world = known->cam_from_world;
    return estimate;
  }
  Camera camera() const override { return camera_; }

 private:
  DatasetPlayer* player_;
  Camera camera_;
};

DatasetPlayer::DatasetPlayer(std::unique_ptr<Dataset> dataset, bool realtime)
    : dataset_(std::move(dataset)),
      source_(PlayBack(std::make_unique<Frames>(this), {.realtime = realtime})),
      poses_(std::make_unique<Poses>(this)) {}

DatasetPlayer::~DatasetPlayer() = default;

std::optional<SourceFrame> DatasetPlayer::Next() {
  std::optional<PosedFrame> posed = dataset_->Next();
  if (!posed) return std::nullopt;
  const std::lock_guard<std::mutex> lock(mutex_);
  known_.push_back({posed->picture, posed->camera, posed->cam_from_world});
  SourceFrame frame;
  frame.index = posed->index;
  frame.timestamp = posed->timestamp;
  frame.name = std::move(posed->name);
  frame.picture = std::move(posed->picture);
  return frame;
}

std::optional<DatasetPlayer::Known> DatasetPlayer::Find(const Picture& picture) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = std::find_if(
      known_.begin(), known_.end(), [&](const Known& k) { return k.picture.get() == &picture; });
  if (found == known_.end()) return std::nullopt;
  Known known = *found;
  // Those before it were dropped on the way.
  known_.erase(known_.begin(), found + 1);
  return known;
}

}  // namespace livemvs
