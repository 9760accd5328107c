#include "livemvs/io/colmap.h"

#include <algorithm>
#include <array>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset_check.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

bool HasModel(const fs::path& folder, const std::string& extension) {
  std::error_code error;
  return fs::is_regular_file(folder / ("cameras" + extension), error) &&
         fs::is_regular_file(folder / ("images" + extension), error);
}

struct ModelLayout {
  const char* name;
  std::size_t parameters;
  bool one_focal_length;  // f cx cy ... instead of fx fy cx cy ...
  CameraModel model;
};

// The models that ours express exactly. The distortion parameters that follow the principal point
// are in the order of Camera::distortion in all of them.
constexpr std::array<ModelLayout, 9> kModels = {{
    {"SIMPLE_PINHOLE", 3, true, CameraModel::kPinhole},
    {"PINHOLE", 4, false, CameraModel::kPinhole},
    {"SIMPLE_RADIAL", 4, true, CameraModel::kBrownConrady},
    {"RADIAL", 5, true, CameraModel::kBrownConrady},
    {"OPENCV", 8, false, CameraModel::kBrownConrady},
    {"FULL_OPENCV", 12, false, CameraModel::kBrownConrady},
    {"OPENCV_FISHEYE", 8, false, CameraModel::kKannalaBrandt},
    {"SIMPLE_RADIAL_FISHEYE", 4, true, CameraModel::kKannalaBrandt},
    {"RADIAL_FISHEYE", 5, true, CameraModel::kKannalaBrandt},
}};

const ModelLayout* FindLayout(const std::string& model) {
  const auto found = std::find_if(kModels.begin(), kModels.end(), [&](const ModelLayout& layout) {
    return model == layout.name;
  });
  return found == kModels.end() ? nullptr : &*found;
}

}  // namespace

namespace colmap_internal {

std::optional<std::size_t> ParameterCount(const std::string& model) {
  const ModelLayout* layout = FindLayout(model);
  if (layout == nullptr) return std::nullopt;
  return layout->parameters;
}

Camera MakeCamera(const std::string& model,
                  std::uint64_t width,
                  std::uint64_t height,
                  const std::vector<double>& params,
                  const std::string& place) {
  const ModelLayout* layout = FindLayout(model);
  if (layout == nullptr) {
    throw BadInput(place + ": the camera model " + model.substr(0, 40) +
                   " is not supported; undistort the images (colmap image_undistorter), or use "
                   "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, "
                   "OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE or RADIAL_FISHEYE");
  }
  if (params.size() != layout->parameters) {
    throw BadInput(place + ": the camera model " + model + " has " +
                   std::to_string(layout->parameters) + " parameters, but " +
                   std::to_string(params.size()) + " are given");
  }
  constexpr std::uint64_t kMaxSize = 32768;
  if (width > kMaxSize || height > kMaxSize || width == 0 || height == 0) {
    throw BadInput(place + ": the image size " + std::to_string(width) + " x " +
                   std::to_string(height) + " is not within 1 ... 32768");
  }
  Camera camera;
  camera.model = layout->model;
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  std::size_t next = 0;
  camera.fx = params[next++];
  camera.fy = layout->one_focal_length ? camera.fx : params[next++];
  // COLMAP's centre of the top-left pixel is (0.5, 0.5), ours is (0, 0).
  camera.cx = params[next++] - 0.5;
  camera.cy = params[next++] - 0.5;
  std::copy(
      params.begin() + static_cast<std::ptrdiff_t>(next), params.end(), camera.distortion.begin());
  return CheckedCamera(camera, place);
}

}  // namespace colmap_internal

std::optional<fs::path> FindColmapModel(const fs::path& folder) {
  for (const char* below : {"", "sparse", "sparse/0"}) {
    const fs::path candidate = *below == '\0' ? folder : folder / below;
    if (HasModel(candidate, ".bin") || HasModel(candidate, ".txt")) return candidate;
  }
  return std::nullopt;
}

ImageSet ReadColmapModel(const fs::path& model_folder) {
  namespace model = colmap_internal;
  const bool binary = HasModel(model_folder, ".bin");
  const std::string extension = binary ? ".bin" : ".txt";
  const fs::path cameras_file = model_folder / ("cameras" + extension);
  const fs::path images_file = model_folder / ("images" + extension);
  const fs::path points_file = model_folder / ("points3D" + extension);
  ImageSet set;
  set.format = binary ? "COLMAP binary model" : "COLMAP text model";
  set.file = images_file;
  const model::Cameras cameras =
      binary ? model::ReadCamerasBinary(cameras_file) : model::ReadCamerasText(cameras_file);
  set.images = binary ? model::ReadImagesBinary(images_file, cameras)
                      : model::ReadImagesText(images_file, cameras);
  std::error_code error;
  if (fs::is_regular_file(points_file, error) && fs::file_size(points_file, error) > 0) {
    set.sparse_points =
        binary ? model::ReadPointsBinary(points_file) : model::ReadPointsText(points_file);
  }
  return set;
}

}  // namespace livemvs
