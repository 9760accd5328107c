#include "livemvs/io/middlebury.h"

#include <cmath>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/dataset_text.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxSkew = 1e-3;  // of fx: below half a pixel at the rim of usual images

Camera ParseCamera(const std::vector<double>& k, const std::string& place) {
  const double scale = k[8];
  constexpr double kTolerance = 1e-9;
  if (std::abs(k[3]) > kTolerance || std::abs(k[6]) > kTolerance || std::abs(k[7]) > kTolerance ||
      !(std::abs(scale) > kTolerance)) {
    throw BadInput(place + ": K is not (fx s cx; 0 fy cy; 0 0 1)");
  }
  Camera camera;
  camera.fx = k[0] / scale;
  camera.fy = k[4] / scale;
  camera.cx = k[2] / scale;
  camera.cy = k[5] / scale;
  const double skew = k[1] / scale;
  if (std::abs(skew) > kMaxSkew * std::abs(camera.fx)) {
    throw BadInput(place + ": K has a skew of " + std::to_string(skew) +
                   ", which is not supported; rectify the images to square axes");
  }
  return CheckedCamera(camera, place);
}

ImageEntry ParseRow(std::string_view line, const std::string& place, const PoseChecker& checker) {
  const std::vector<std::string_view> words = SplitWords(line);
  constexpr std::size_t kWords = 1 + 9 + 9 + 3;
  if (words.size() != kWords) {
    throw BadInput(place + ": " + std::to_string(words.size()) +
                   " words where an image is: name K(9) R(9) t(3), 22 in all");
  }
  const std::vector<double> v = FiniteNumbers({words.begin() + 1, words.end()}, place, "K, R or t");
  ImageEntry image;
  image.name = words[0];
  image.place = place;
  image.camera = ParseCamera({v.begin(), v.begin() + 9}, place);
  const Eigen::Matrix3d r = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&v[9]);
  image.cam_from_world.rotation = checker.FromMatrix(r, place);
  image.cam_from_world.translation = {v[18], v[19], v[20]};
  return image;
}

// Two lines of three numbers each after one that speaks of a bounding box.
std::optional<Box> FindBox(const fs::path& readme) {
  std::error_code error;
  if (!fs::is_regular_file(readme, error)) return std::nullopt;
  const std::string text = ReadTextFile(readme, std::size_t{1} << 20);
  LineReader lines(text);
  bool spoken_of = false;
  std::vector<Eigen::Vector3d> corners;
  while (const auto line = lines.NextContent()) {
    if (ToLower(*line).find("bounding box") != std::string::npos) {
      spoken_of = true;
      corners.clear();
      continue;
    }
    if (!spoken_of || corners.size() == 2) continue;
    const std::vector<std::string_view> words = SplitWords(*line, "(),;[]");
    Eigen::Vector3d corner;
    bool numbers = words.size() == 3;
    for (int i = 0; numbers && i < 3; ++i) {
      const std::optional<double> value = ParseNumber(words[static_cast<std::size_t>(i)]);
      numbers = value && std::isfinite(*value);
      if (numbers) corner[i] = *value;
    }
    if (numbers) corners.push_back(corner);
  }
  if (corners.size() != 2) return std::nullopt;
  const Box box{corners[0].cwiseMin(corners[1]), corners[0].cwiseMax(corners[1])};
  if ((box.max.array() > box.min.array()).all()) return box;
  LogWarning(readme.string() + ": the bounding box is flat and not used");
  return std::nullopt;
}

}  // namespace

std::optional<fs::path> FindMiddlebury(const fs::path& folder) {
  constexpr std::string_view kEnding = "_par.txt";
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.size() > kEnding.size() && name.ends_with(kEnding)) found.push_back(it->path());
  }
  if (found.empty()) return std::nullopt;
  if (found.size() > 1) {
    throw BadInput(folder.string() + ": holds several *_par.txt (" + found[0].filename().string() +
                   ", " + found[1].filename().string() + "); name the one to use with --data");
  }
  return found[0];
}

ImageSet ReadMiddlebury(const fs::path& par_file) {
  ImageSet set;
  set.format = "Middlebury views";
  set.file = par_file;
  set.root = set.image_folder = par_file.parent_path().empty() ? "." : par_file.parent_path();
  set.box = FindBox(set.root / "README.txt");
  const std::string text = ReadTextFile(par_file);
  LineReader lines(text);
  const auto head = lines.NextContent();
  if (!head) throw BadInput(par_file.string() + ": holds no image");
  const double count = FiniteNumber(*head, Place(par_file, lines.line()), "number of images");
  const PoseChecker checker;
  while (const auto line = lines.NextContent()) {
    set.images.push_back(ParseRow(*line, Place(par_file, lines.line()), checker));
  }
  if (count != static_cast<double>(set.images.size())) {
    throw BadInput(par_file.string() + ": states " + std::string(*head) + " images, but " +
                   std::to_string(set.images.size()) +
                   " rows follow; the file is cut, or its first line is wrong");
  }
  return set;
}

}  // namespace livemvs
