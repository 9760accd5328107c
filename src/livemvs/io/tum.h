#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/io/dataset_images.h"

namespace livemvs {

/// A camera's path in time. [s]
class Trajectory {
 public:
  /// @param times            [s], strictly increasing.
  /// @param world_from_cams  As many, in our axes.
  Trajectory(std::vector<double> times, std::vector<Rigid3d> world_from_cams);

  std::size_t size() const { return times_.size(); }
  double front_time() const { return times_.front(); }
  double back_time() const { return times_.back(); }
  const std::vector<double>& times() const { return times_; }

  /// cam_from_world at a time: the pose written down for it (within half a millisecond), or the
  /// interpolated one where poses stand within 0.1 s on both sides; otherwise nothing.
  std::optional<Rigid3d> At(double time) const;

 private:
  std::vector<double> times_;
  std::vector<Rigid3d> world_from_cams_;
};

/// Reads rows `time tx ty tz qx qy qz qw`. kAuto means world_from_cam, as the form has it.
/// @throws Error (kBadInput) naming file, line and remedy.
Trajectory ReadTumTrajectory(const std::filesystem::path& file, PoseConvention convention);

/// A pose and when it was. [s]
struct StampedPose {
  double time = 0;
  Rigid3d cam_from_world;
};

/// Writes rows `time tx ty tz qx qy qz qw` of world_from_cam, as ReadTumTrajectory() reads them.
/// The file appears whole or not at all.
/// @param comment  Its first line, after "# ".
/// @throws Error (kOutOfResource) where it cannot be written.
void WriteTumTrajectory(const std::filesystem::path& file,
                        const std::vector<StampedPose>& poses,
                        const std::string& comment);

/// Reads a data set in the form of the TUM benchmark: rgb.txt, groundtruth.txt (or trajectory.txt)
/// and a calibration (camera.yaml, or `camera`, as in DatasetOptions). Images without a pose at
/// their time are left out and counted.
ImageSet ReadTumDataset(const std::filesystem::path& folder,
                        const std::string& camera,
                        PoseConvention convention);

}  // namespace livemvs
