#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// What the rows of a pose file mean.
enum class PoseConvention {
  kAuto,               ///< TUM rows: world_from_cam; 3x4 rows: cam_from_world.
  kCamFromWorld,       ///< Axes x right, y down, z forward.
  kWorldFromCam,       ///< Axes x right, y down, z forward.
  kWorldFromCamOpenGl  ///< Axes x right, y up, z backward.
};

struct DatasetOptions {
  std::filesystem::path data;  ///< A dataset folder, a file inside it that defines it, or a video.
  std::filesystem::path
      poses;  ///< Pose file for a video or image folder; empty: found in the folder.
  std::filesystem::path images;  ///< Image folder, where not the one that the format implies.
  std::string camera;            ///< OpenCV YAML file, or "fx,fy,cx,cy[,dist...]"; empty: found.
  PoseConvention pose_convention = PoseConvention::kAuto;
  std::int64_t first_frame = 0;  ///< Frames before it are passed over.
  std::int64_t last_frame = -1;  ///< Last frame to use; -1: all.
  std::int64_t step = 1;         ///< Use every step-th frame.
  /// Asked while frames are passed over; true ends the dataset there. May be empty.
  std::function<bool()> cancelled;
};

/// A camera of the dataset: what is known before any picture is read.
struct DatasetView {
  std::int64_t index = 0;
  double timestamp = 0;
  std::string name;
  Camera camera;
  Rigid3d cam_from_world;
  std::filesystem::path file{};  ///< The picture's own; empty for a frame of a video.
};

/// Pictures with poses and intrinsics, in our conventions (integer pixel centres; x right, y down,
/// z forward; cam_from_world), from any of the supported formats. Not thread-safe.
class Dataset {
 public:
  struct Statistics {
    std::int64_t decoded = 0;  ///< Pictures handed out.
    std::int64_t skipped = 0;  ///< Pictures lost: damaged, missing, or without a pose.
  };

  virtual ~Dataset() = default;

  /// For people: "COLMAP text model, 218 images".
  virtual std::string description() const = 0;

  /// The views that Next() is to hand out, in order. Some may be lost on the way.
  virtual const std::vector<DatasetView>& views() const = 0;

  /// Points that the format brings along (COLMAP's sparse model), in the world; often empty.
  virtual const std::vector<Eigen::Vector3d>& sparse_points() const = 0;

  /// The region of interest that the format brings along (Middlebury's README), if any.
  virtual std::optional<Box> box() const = 0;

  virtual Statistics statistics() const = 0;

  /// The next frame, or nothing at the end.
  virtual std::optional<PosedFrame> Next() = 0;
};

/// Finds out what `options.data` is and opens it. All metadata is read and checked here.
/// @throws Error (kBadInput) naming file, place and remedy.
std::unique_ptr<Dataset> OpenDataset(const DatasetOptions& options);

}  // namespace livemvs
