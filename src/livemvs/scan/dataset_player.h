#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "livemvs/io/dataset.h"
#include "livemvs/io/live_source.h"
#include "livemvs/tracking/pose_source.h"

namespace livemvs {

/// Plays a data set that has poses as if it were filmed now: a source of pictures, and the poses
/// that belong to them. Source and poses may be used from two threads.
class DatasetPlayer {
 public:
  /// @param realtime  At the pace at which it was filmed.
  DatasetPlayer(std::unique_ptr<Dataset> dataset, bool realtime);
  ~DatasetPlayer();

  LiveSource* source() { return source_.get(); }
  PoseSource* poses() { return poses_.get(); }
  const Dataset& dataset() const { return *dataset_; }

 private:
  struct Known {
    std::shared_ptr<const Picture> picture;
    Camera camera;
    Rigid3d cam_from_world;
  };
  class Frames;
  class Poses;

  std::optional<SourceFrame> Next();
  std::optional<Known> Find(const Picture& picture);

  std::unique_ptr<Dataset> dataset_;
  std::mutex mutex_;
  std::deque<Known> known_;  ///< Of pictures on their way, in their order.
  std::unique_ptr<LiveSource> source_;
  std::unique_ptr<PoseSource> poses_;
};

}  // namespace livemvs
