#include "livemvs/io/pose_file.h"

#include <cmath>

#include "livemvs/core/error.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/dataset_text.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTumWords = 8;
constexpr std::size_t kMatrixWords = 12;

Eigen::Matrix3d RowMajor3(const double* v) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v);
}

std::int64_t FrameNumber(double value, const std::string& place) {
  constexpr double kMaxFrame = 1e12;
  if (value < 0 || value > kMaxFrame || value != std::floor(value)) {
    throw BadInput(place + ": the first of 13 numbers must be the frame's number, from 0");
  }
  return static_cast<std::int64_t>(value);
}

NumberedPoses ReadMatrixRows(const fs::path& file,
                             std::string_view text,
                             PoseConvention convention) {
  LineReader lines(text);
  const PoseChecker checker;
  NumberedPoses poses;
  std::size_t columns = 0;
  while (const auto line = lines.NextContent()) {
    const std::string place = Place(file, lines.line());
    const std::vector<double> v = FiniteNumbers(SplitWords(*line, ","), place, "pose");
    if (columns == 0) columns = v.size();
    if (v.size() != columns || (columns != kMatrixWords && columns != kMatrixWords + 1)) {
      throw BadInput(place + ": " + std::to_string(v.size()) +
                     " numbers; a pose is a 3x4 matrix by rows (12), with the frame's number in "
                     "front (13), or time tx ty tz qx qy qz qw (8), the same on all lines");
    }
    poses.explicit_numbers = columns == kMatrixWords + 1;
    const double* m = v.data() + (poses.explicit_numbers ? 1 : 0);
    Eigen::Matrix3d rotation;
    rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    const Rigid3d written{checker.FromMatrix(rotation, place), {m[3], m[7], m[11]}};
    const std::int64_t frame = poses.explicit_numbers
                                   ? FrameNumber(v[0], place)
                                   : static_cast<std::int64_t>(poses.cam_from_world.size());
    if (!poses.cam_from_world.emplace(frame, CamFromWorld(written, convention)).second) {
      throw BadInput(place + ": frame " + std::to_string(frame) + " has a pose already");
    }
  }
  return poses;
}

ImageEntry ParseCamsRow(std::string_view line,
                        const std::string& place,
                        const PoseChecker& checker) {
  const std::vector<std::string_view> words = SplitWords(line);
  constexpr std::size_t kWords = 1 + 2 + 4 + 4 + 9 + 3;
  if (words.size() != kWords) {
    throw BadInput(place + ": " + std::to_string(words.size()) +
                   " words where an image is: image width height fx fy cx cy k1 k2 p1 p2 R(9) "
                   "t(3), 23 in all");
  }
  const std::vector<double> v = FiniteNumbers({words.begin() + 1, words.end()}, place, "camera");
  constexpr double kMaxSize = 32768;
  if (!(v[0] >= 1 && v[0] <= kMaxSize && v[1] >= 1 && v[1] <= kMaxSize) ||
      v[0] != std::floor(v[0]) || v[1] != std::floor(v[1])) {
    throw BadInput(place + ": width and height are not an image size in pixels");
  }
  ImageEntry image;
  image.name = words[0];
  image.place = place;
  image.camera.model = CameraModel::kBrownConrady;
  image.camera.width = static_cast<int>(v[0]);
  image.camera.height = static_cast<int>(v[1]);
  image.camera.fx = v[2];
  image.camera.fy = v[3];
  image.camera.cx = v[4];
  image.camera.cy = v[5];
  image.camera.distortion = {v[6], v[7], v[8], v[9]};
  image.camera = CheckedCamera(image.camera, place);
  image.cam_from_world.rotation = checker.FromMatrix(RowMajor3(&v[10]), place);
  image.cam_from_world.translation = {v[19], v[20], v[21]};
  return image;
}

}  // namespace

Rigid3d CamFromWorld(const Rigid3d& written, PoseConvention convention) {
  switch (convention) {
    case PoseConvention::kWorldFromCam:
      return written.Inverse();
    case PoseConvention::kWorldFromCamOpenGl:
      return FromOpenGl(written);
    case PoseConvention::kAuto:
    case PoseConvention::kCamFromWorld:
      break;
  }
  return written;
}

Poses ReadPoseFile(const fs::path& file, PoseConvention convention) {
  const std::string text = ReadTextFile(file);
  LineReader lines(text);
  const auto first = lines.NextContent();
  if (!first) throw BadInput(file.string() + ": holds no pose");
  if (SplitWords(*first, ",").size() == kTumWords) return ReadTumTrajectory(file, convention);
  return ReadMatrixRows(file, text, convention);
}

std::optional<fs::path> FindPoseFile(const fs::path& folder) {
  for (const char* name : {"poses.txt", "trajectory.txt", "groundtruth.txt", "poses.tum"}) {
    std::error_code error;
    if (fs::is_regular_file(folder / name, error)) return folder / name;
  }
  return std::nullopt;
}

ImageSet ReadCamsFile(const fs::path& file) {
  ImageSet set;
  set.format = "list of cameras";
  set.file = file;
  set.root = set.image_folder = file.parent_path().empty() ? "." : file.parent_path();
  const std::string text = ReadTextFile(file);
  LineReader lines(text);
  const PoseChecker checker;
  while (const auto line = lines.NextContent()) {
    set.images.push_back(ParseCamsRow(*line, Place(file, lines.line()), checker));
  }
  return set;
}

}  // namespace livemvs
