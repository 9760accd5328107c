#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/point.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// The pose of one picture of a recording.
struct TrackedPose {
  std::int64_t frame = 0;  ///< Number in the recording, from 0.
  double timestamp = 0;    ///< [s] since the first frame.
  std::string image;       ///< Path of the image file as other programs are to find it.
  Rigid3d cam_from_world;
};

/// Writes rows `frame` and the 3x4 matrix cam_from_world; what ReadPoseFile reads.
void WritePoseRows(const std::filesystem::path& file, const std::vector<TrackedPose>& poses);

/// Writes transforms.json as instant-ngp and nerfstudio read it: world_from_cam with OpenGL's axes,
/// the principal point counted from the corner of the image.
void WriteTransforms(const std::filesystem::path& file,
                     const Camera& camera,
                     const std::vector<TrackedPose>& poses);

/// Writes a COLMAP text model without points: cameras.txt, images.txt, points3D.txt in `folder`,
/// which is made where it does not exist.
void WriteColmapText(const std::filesystem::path& folder,
                     const Camera& camera,
                     const std::vector<TrackedPose>& poses);

/// A picture with a pose, and with a camera that need not be that of the others.
struct PosedImage {
  std::string image;  ///< Path of the image file as other programs are to find it.
  Camera camera;
  Rigid3d cam_from_world;
};

/// Writes transforms.json as above; intrinsics stand once where all pictures share them, else in
/// each frame.
/// @param ply_file_path  Cloud to start from, as nerfstudio is to find it; empty: none.
void WriteTransforms(const std::filesystem::path& file,
                     const std::vector<PosedImage>& images,
                     const std::string& ply_file_path);

/// Writes a COLMAP text model as above, equal cameras once, with a cloud as its points: their
/// colours, no tracks, and the reprojection error -1, COLMAP's word for unknown.
void WriteColmapText(const std::filesystem::path& folder,
                     const std::vector<PosedImage>& images,
                     const PointCloud& cloud);

// WriteTransforms() and WriteColmapText() throw std::invalid_argument naming the picture where its
// camera is one that these forms cannot hold: with a negative fy.

// All of them throw Error (kOutOfResource) naming the file where it cannot be written; each file
// appears whole or not at all.

}  // namespace livemvs
