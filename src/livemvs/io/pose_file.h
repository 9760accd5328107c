#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "livemvs/io/dataset_images.h"
#include "livemvs/io/tum.h"

namespace livemvs {

/// cam_from_world in our axes from a pose as written. kAuto means kCamFromWorld.
Rigid3d CamFromWorld(const Rigid3d& written, PoseConvention convention);

/// Poses by the number of their frame.
struct NumberedPoses {
  std::map<std::int64_t, Rigid3d> cam_from_world;
  bool explicit_numbers = false;  ///< Stated in the file; otherwise the rows are counted from 0.
};

using Poses = std::variant<NumberedPoses, Trajectory>;

/// Reads rows of a 3x4 matrix (12 numbers, row-major), with or without the frame's number in front,
/// or rows of a TUM trajectory (8 numbers): told apart by their length. kAuto means cam_from_world
/// for the former, world_from_cam for the latter.
/// @throws Error (kBadInput) naming file, line and remedy.
Poses ReadPoseFile(const std::filesystem::path& file, PoseConvention convention);

/// The pose file in a folder, by its usual names, if any.
std::optional<std::filesystem::path> FindPoseFile(const std::filesystem::path& folder);

/// Reads a file with one line for each image: `image width height fx fy cx cy k1 k2 p1 p2 R(9)
/// t(3)`, cam_from_world, integer pixel centres.
/// @throws Error (kBadInput) naming file, line and remedy.
ImageSet ReadCamsFile(const std::filesystem::path& file);

}  // namespace livemvs
