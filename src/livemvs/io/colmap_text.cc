#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "livemvs/core/error.h"
#include "livemvs/io/colmap.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/dataset_text.h"

namespace livemvs::colmap_internal {
namespace {

using Words = std::vector<std::string_view>;

std::uint64_t WholeNumber(std::string_view word,
                          std::uint64_t max,
                          const std::string& place,
                          const std::string& what) {
  const double value = FiniteNumber(word, place, what);
  if (value < 0 || value > static_cast<double>(max) || value != std::floor(value)) {
    throw BadInput(place + ": '" + std::string(word.substr(0, 40)) + "' is not a valid " + what);
  }
  return static_cast<std::uint64_t>(value);
}

std::uint32_t CameraId(std::string_view word, const std::string& place) {
  return static_cast<std::uint32_t>(
      WholeNumber(word, std::numeric_limits<std::uint32_t>::max(), place, "camera id"));
}

// IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME
constexpr std::size_t kImageWords = 10;

// A line of an image's observations holds numbers only, an image's line ends with its name.
bool IsImageLine(const Words& words) {
  return words.size() >= kImageWords && !ParseNumber(words[kImageWords - 1]);
}

ImageEntry ParseImage(std::string_view line,
                      const Words& words,
                      const std::string& place,
                      const Cameras& cameras,
                      PoseChecker& checker) {
  if (words.size() < kImageWords) {
    throw BadInput(place + ": " + std::to_string(words.size()) +
                   " words where an image has 10: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
  }
  const std::vector<double> v =
      FiniteNumbers(Words(words.begin() + 1, words.begin() + 8), place, "pose of an image");
  ImageEntry image;
  image.place = place;
  image.cam_from_world.rotation = checker.FromQuaternion(v[0], v[1], v[2], v[3], place);
  image.cam_from_world.translation = {v[4], v[5], v[6]};
  const auto camera = cameras.find(CameraId(words[8], place));
  if (camera == cameras.end()) {
    throw BadInput(place + ": camera " + std::string(words[8].substr(0, 40)) +
                   " is not among the model's cameras");
  }
  image.camera = camera->second;
  // Names may hold blanks: all of the rest of the line.
  const char* name = words[kImageWords - 1].data();
  image.name = Trim(line.substr(static_cast<std::size_t>(name - line.data())));
  return image;
}

}  // namespace

Cameras ReadCamerasText(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  LineReader lines(text);
  Cameras cameras;
  while (const auto line = lines.NextContent()) {
    const std::string place = Place(path, lines.line());
    const Words words = SplitWords(*line);
    if (words.size() < 5) {
      throw BadInput(place + ": a camera is CAMERA_ID MODEL WIDTH HEIGHT PARAMS...");
    }
    const std::vector<double> params =
        FiniteNumbers(Words(words.begin() + 4, words.end()), place, "camera parameter");
    constexpr std::uint64_t kAnySize = std::uint64_t{1} << 48;
    const Camera camera = MakeCamera(std::string(words[1]),
                                     WholeNumber(words[2], kAnySize, place, "image width"),
                                     WholeNumber(words[3], kAnySize, place, "image height"),
                                     params,
                                     place);
    if (!cameras.emplace(CameraId(words[0], place), camera).second) {
      throw BadInput(place + ": the camera id occurs twice");
    }
  }
  if (cameras.empty()) throw BadInput(path.string() + ": holds no camera");
  return cameras;
}

std::vector<ImageEntry> ReadImagesText(const std::filesystem::path& path, const Cameras& cameras) {
  const std::string text = ReadTextFile(path);
  LineReader lines(text);
  PoseChecker checker;
  std::vector<ImageEntry> images;
  bool observations_next = false;
  while (const auto raw = lines.Next()) {
    const std::string_view line = Trim(*raw);
    if (!line.empty() && line.front() == '#') continue;
    const Words words = SplitWords(line);
    // The second line of an image holds its observations, which are not needed; it may be blank,
    // and some writers leave it out.
    if (line.empty() || (observations_next && !IsImageLine(words))) {
      observations_next = false;
      continue;
    }
    images.push_back(ParseImage(line, words, Place(path, lines.line()), cameras, checker));
    observations_next = true;
  }
  return images;
}

std::vector<Eigen::Vector3d> ReadPointsText(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  LineReader lines(text);
  std::vector<Eigen::Vector3d> points;
  while (const auto line = lines.NextContent()) {
    const std::string place = Place(path, lines.line());
    const Words words = SplitWords(*line);
    if (words.size() < 4) {
      throw BadInput(place + ": a point is POINT3D_ID X Y Z R G B ERROR TRACK...");
    }
    const std::vector<double> v =
        FiniteNumbers(Words(words.begin() + 1, words.begin() + 4), place, "position of a point");
    points.emplace_back(v[0], v[1], v[2]);
  }
  return points;
}

}  // namespace livemvs::colmap_internal
