#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include "livemvs/core/error.h"
#include "livemvs/io/colmap.h"
#include "livemvs/io/dataset_check.h"

namespace livemvs::colmap_internal {
namespace {

static_assert(std::endian::native == std::endian::little, "COLMAP's files are little-endian");

// COLMAP's model ids, in order.
constexpr std::array<const char*, 18> kModelNames = {"SIMPLE_PINHOLE",
                                                     "PINHOLE",
                                                     "SIMPLE_RADIAL",
                                                     "RADIAL",
                                                     "OPENCV",
                                                     "OPENCV_FISHEYE",
                                                     "FULL_OPENCV",
                                                     "FOV",
                                                     "SIMPLE_RADIAL_FISHEYE",
                                                     "RADIAL_FISHEYE",
                                                     "THIN_PRISM_FISHEYE",
                                                     "RAD_TAN_THIN_PRISM_FISHEYE"};

// Reads values from a file and knows how many bytes are left, so that no count is believed that
// the file cannot hold.
class BinaryReader {
 public:
  explicit BinaryReader(const std::filesystem::path& path)
      : path_(path), stream_(path, std::ios::binary) {
    std::error_code error;
    remaining_ = std::filesystem::file_size(path, error);
    if (error || !stream_) throw BadInput(path.string() + ": cannot be read");
  }

  template <typename T>
  T Read(const char* what) {
    T value;
    ReadBytes(&value, sizeof(T), what);
    return value;
  }

  double ReadFinite(const char* what) {
    const double value = Read<double>(what);
    if (!std::isfinite(value)) throw BadInput(Here() + ": " + what + " is not a finite number");
    return value;
  }

  // A count of things of at least `bytes_each` bytes.
  std::uint64_t ReadCount(std::uint64_t bytes_each, const char* what) {
    const std::uint64_t count = Read<std::uint64_t>(what);
    if (count > remaining_ / bytes_each) {
      throw BadInput(Here() + ": states " + std::to_string(count) + " " + what + ", but only " +
                     std::to_string(remaining_) + " bytes follow; the file is damaged or cut");
    }
    return count;
  }

  std::string ReadName() {
    constexpr std::size_t kLongest = 4096;
    std::string name;
    while (const char c = Read<char>("image name")) {
      name.push_back(c);
      if (name.size() > kLongest) throw BadInput(Here() + ": an image name without an end");
    }
    return name;
  }

  void Skip(std::uint64_t bytes, const char* what) {
    if (bytes > remaining_) throw Cut(what);
    stream_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
    remaining_ -= bytes;
    offset_ += bytes;
  }

  std::string Here() const { return path_.string() + ": byte " + std::to_string(offset_); }

 private:
  void ReadBytes(void* to, std::size_t bytes, const char* what) {
    if (bytes > remaining_) throw Cut(what);
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
    if (!stream_) throw Cut(what);
    remaining_ -= bytes;
    offset_ += bytes;
  }

  Error Cut(const char* what) const {
    return BadInput(Here() + ": the file ends within " + what + "; it is damaged or cut");
  }

  std::filesystem::path path_;
  std::ifstream stream_;
  std::uint64_t remaining_ = 0;
  std::uint64_t offset_ = 0;
};

}  // namespace

Cameras ReadCamerasBinary(const std::filesystem::path& path) {
  BinaryReader reader(path);
  constexpr std::uint64_t kSmallestCamera = 4 + 4 + 8 + 8 + 3 * 8;
  const std::uint64_t count = reader.ReadCount(kSmallestCamera, "cameras");
  Cameras cameras;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string place = reader.Here();
    const std::uint32_t id = reader.Read<std::uint32_t>("camera");
    const std::int32_t model = reader.Read<std::int32_t>("camera");
    const std::uint64_t width = reader.Read<std::uint64_t>("camera");
    const std::uint64_t height = reader.Read<std::uint64_t>("camera");
    const bool known = model >= 0 && model < static_cast<int>(kModelNames.size()) &&
                       kModelNames[static_cast<std::size_t>(model)] != nullptr;
    const std::string name =
        known ? kModelNames[static_cast<std::size_t>(model)] : "number " + std::to_string(model);
    std::vector<double> params(ParameterCount(name).value_or(0));
    for (double& p : params) p = reader.ReadFinite("camera parameter");
    // Throws by name for the models without a counterpart, before the next camera is looked for.
    const Camera camera = MakeCamera(name, width, height, params, place);
    if (!cameras.emplace(id, camera).second) {
      throw BadInput(place + ": the camera id " + std::to_string(id) + " occurs twice");
    }
  }
  if (cameras.empty()) throw BadInput(path.string() + ": holds no camera");
  return cameras;
}

std::vector<ImageEntry> ReadImagesBinary(const std::filesystem::path& path,
                                         const Cameras& cameras) {
  BinaryReader reader(path);
  constexpr std::uint64_t kSmallestImage = 4 + 7 * 8 + 4 + 1 + 8;
  const std::uint64_t count = reader.ReadCount(kSmallestImage, "images");
  PoseChecker checker;
  std::vector<ImageEntry> images;
  images.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    ImageEntry image;
    image.place = reader.Here();
    reader.Read<std::uint32_t>("image");
    std::array<double, 7> v;
    for (double& value : v) value = reader.ReadFinite("pose of an image");
    image.cam_from_world.rotation = checker.FromQuaternion(v[0], v[1], v[2], v[3], image.place);
    image.cam_from_world.translation = {v[4], v[5], v[6]};
    const std::uint32_t camera_id = reader.Read<std::uint32_t>("image");
    const auto camera = cameras.find(camera_id);
    if (camera == cameras.end()) {
      throw BadInput(image.place + ": camera " + std::to_string(camera_id) +
                     " is not among the model's cameras");
    }
    image.camera = camera->second;
    image.name = reader.ReadName();
    constexpr std::uint64_t kObservation = 8 + 8 + 8;
    const std::uint64_t observations = reader.ReadCount(kObservation, "observations of an image");
    reader.Skip(observations * kObservation, "observations of an image");
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<Eigen::Vector3d> ReadPointsBinary(const std::filesystem::path& path) {
  BinaryReader reader(path);
  constexpr std::uint64_t kSmallestPoint = 8 + 3 * 8 + 3 + 8 + 8;
  const std::uint64_t count = reader.ReadCount(kSmallestPoint, "points");
  std::vector<Eigen::Vector3d> points;
  points.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    reader.Read<std::uint64_t>("point");
    Eigen::Vector3d point;
    for (int k = 0; k < 3; ++k) point[k] = reader.ReadFinite("position of a point");
    reader.Skip(3 + 8, "point");
    constexpr std::uint64_t kTrackElement = 4 + 4;
    const std::uint64_t track = reader.ReadCount(kTrackElement, "observations of a point");
    reader.Skip(track * kTrackElement, "observations of a point");
    points.push_back(point);
  }
  return points;
}

}  // namespace livemvs::colmap_internal
