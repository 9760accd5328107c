#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/io/dataset_images.h"

namespace livemvs {

/// The folder of a COLMAP model (cameras and images, .bin or .txt) in `folder`, `folder`/sparse or
/// `folder`/sparse/0, if any.
std::optional<std::filesystem::path> FindColmapModel(const std::filesystem::path& folder);

/// Reads a COLMAP model, binary where both forms are present. COLMAP counts pixels from the corner
/// of the image: cx = cx_colmap - 0.5. The images' folder is left open.
/// @throws Error (kBadInput) naming file, place and remedy.
ImageSet ReadColmapModel(const std::filesystem::path& model_folder);

namespace colmap_internal {

/// Our camera from a COLMAP model's name and parameters.
/// @throws Error (kBadInput), by name where the model has no exact counterpart here.
Camera MakeCamera(const std::string& model,
                  std::uint64_t width,
                  std::uint64_t height,
                  const std::vector<double>& params,
                  const std::string& place);

/// Number of parameters of a model by its name, or nothing where the name is unknown.
std::optional<std::size_t> ParameterCount(const std::string& model);

using Cameras = std::map<std::uint32_t, Camera>;

Cameras ReadCamerasText(const std::filesystem::path& path);
std::vector<ImageEntry> ReadImagesText(const std::filesystem::path& path, const Cameras& cameras);
std::vector<Eigen::Vector3d> ReadPointsText(const std::filesystem::path& path);

Cameras ReadCamerasBinary(const std::filesystem::path& path);
std::vector<ImageEntry> ReadImagesBinary(const std::filesystem::path& path, const Cameras& cameras);
std::vector<Eigen::Vector3d> ReadPointsBinary(const std::filesystem::path& path);

}  // namespace colmap_internal
}  // namespace livemvs
