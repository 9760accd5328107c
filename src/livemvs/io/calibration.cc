#include "livemvs/io/calibration.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "livemvs/core/error.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/dataset_text.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxYamlBytes = std::size_t{1} << 20;

double YamlNumber(const YAML::Node& node, const fs::path& file, const std::string& key) {
  if (!node.IsScalar()) throw BadInput(file.string() + ": '" + key + "' is not a number");
  return FiniteNumber(node.Scalar(), file.string(), key);
}

// The numbers of "key: !!opencv-matrix {rows, cols, data}", or of a plain list; empty if absent.
std::vector<double> YamlMatrix(const YAML::Node& root, const fs::path& file, const char* key) {
  const YAML::Node node = root[key];
  if (!node) return {};
  const YAML::Node data = node.IsMap() ? node["data"] : node;
  if (!data || !data.IsSequence()) {
    throw BadInput(file.string() + ": '" + key + "' has no list of numbers ('data')");
  }
  std::vector<double> values;
  for (const YAML::Node& value : data) {
    if (value.IsSequence()) {  // a matrix as a list of rows
      for (const YAML::Node& inner : value) values.push_back(YamlNumber(inner, file, key));
    } else {
      values.push_back(YamlNumber(value, file, key));
    }
    constexpr std::size_t kMost = 64;  // aliases can make a small file long
    if (values.size() > kMost) throw BadInput(file.string() + ": '" + key + "' is too long");
  }
  return values;
}

int YamlSize(const YAML::Node& root, const fs::path& file, const char* key) {
  const YAML::Node node = root[key];
  if (!node) return 0;
  const double value = YamlNumber(node, file, key);
  constexpr double kMaxSize = 32768;
  if (value < 1 || value > kMaxSize || value != std::floor(value)) {
    throw BadInput(file.string() + ": '" + key + "' is not an image size in pixels");
  }
  return static_cast<int>(value);
}

YAML::Node LoadYaml(const fs::path& file) {
  std::string text = ReadTextFile(file, kMaxYamlBytes);
  // OpenCV's first line, "%YAML:1.0", is no YAML directive.
  if (text.rfind("%YAML:", 0) == 0) text.replace(0, std::min(text.find('\n'), text.size()), "");
  try {
    YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) throw BadInput(file.string() + ": not a YAML map of names and values");
    return root;
  } catch (const YAML::Exception& e) {
    throw BadInput(Place(file, static_cast<std::size_t>(std::max(0, e.mark.line + 1))) +
                   ": not valid YAML: " + e.msg);
  }
}

bool SaysFisheye(const YAML::Node& root) {
  for (const char* key : {"distortion_model", "camera_model", "model"}) {
    const YAML::Node node = root[key];
    if (!node || !node.IsScalar()) continue;
    const std::string name = ToLower(node.Scalar());
    if (name.find("fisheye") != std::string::npos || name == "equidistant") return true;
  }
  return false;
}

void SetMatrix(const std::vector<double>& k, const std::string& place, Camera& camera) {
  if (k.size() != 9) {
    throw BadInput(place + ": 'camera_matrix' has " + std::to_string(k.size()) +
                   " numbers, not 9 (3 rows of 3)");
  }
  constexpr double kTolerance = 1e-6;
  if (std::abs(k[3]) > kTolerance || std::abs(k[6]) > kTolerance || std::abs(k[7]) > kTolerance ||
      std::abs(k[8] - 1) > kTolerance || std::abs(k[1]) > kTolerance * std::abs(k[0])) {
    throw BadInput(place + ": 'camera_matrix' is not (fx 0 cx; 0 fy cy; 0 0 1)");
  }
  camera.fx = k[0];
  camera.fy = k[4];
  camera.cx = k[2];
  camera.cy = k[5];
}

void SetDistortion(const std::vector<double>& values,
                   bool fisheye,
                   const std::string& place,
                   Camera& camera) {
  std::vector<double> k = values;
  // OpenCV appends thin-prism and tilt terms, which are often zero.
  while (k.size() > 8 && k.back() == 0) k.pop_back();
  const std::size_t n = k.size();
  const bool fits = fisheye ? n == 0 || n == 4 : n == 0 || n == 4 || n == 5 || n == 8;
  if (!fits) {
    throw BadInput(place + ": " + std::to_string(n) + " distortion coefficients; supported are " +
                   (fisheye ? "4 (k1 k2 k3 k4)" : "4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6)"));
  }
  camera.model = fisheye ? CameraModel::kKannalaBrandt : CameraModel::kBrownConrady;
  std::copy(k.begin(), k.end(), camera.distortion.begin());
}

}  // namespace

Camera ReadOpenCvYaml(const fs::path& file) {
  try {
    const YAML::Node root = LoadYaml(file);
    Camera camera;
    const std::vector<double> matrix = YamlMatrix(root, file, "camera_matrix");
    if (matrix.empty()) {
      throw BadInput(file.string() +
                     ": has no 'camera_matrix'; OpenCV's calibration YAML is needed");
    }
    SetMatrix(matrix, file.string(), camera);
    SetDistortion(YamlMatrix(root, file, "distortion_coefficients"),
                  SaysFisheye(root),
                  file.string(),
                  camera);
    camera.width = YamlSize(root, file, "image_width");
    camera.height = YamlSize(root, file, "image_height");
    if ((camera.width == 0) != (camera.height == 0)) camera.width = camera.height = 0;
    return CheckedCamera(camera, file.string());
  } catch (const YAML::Exception& e) {
    throw BadInput(file.string() + ": " + e.what());
  }
}

Camera ReadIntrinsicsText(const fs::path& file) {
  const std::string text = ReadTextFile(file);
  LineReader lines(text);
  const auto line = lines.NextContent();
  const std::string place = Place(file, lines.line());
  const std::vector<double> v =
      FiniteNumbers(SplitWords(line.value_or(""), ","), place, "fx fy cx cy [width height]");
  if (v.size() != 4 && v.size() != 6) {
    throw BadInput(place + ": " + std::to_string(v.size()) +
                   " numbers where fx fy cx cy [width height] is expected");
  }
  Camera camera;
  camera.fx = v[0];
  camera.fy = v[1];
  camera.cx = v[2];
  camera.cy = v[3];
  if (v.size() == 6) {
    constexpr double kMaxSize = 32768;
    if (!(v[4] >= 1 && v[5] >= 1 && v[4] <= kMaxSize && v[5] <= kMaxSize)) {
      throw BadInput(place + ": width and height are not an image size in pixels");
    }
    camera.width = static_cast<int>(v[4]);
    camera.height = static_cast<int>(v[5]);
  }
  return CheckedCamera(camera, place);
}

Camera ParseCameraList(const std::string& list) {
  const std::string place = "--camera '" + list.substr(0, 200) + "'";
  try {
    const std::vector<double> v =
        FiniteNumbers(SplitWords(list, ","), place, "fx,fy,cx,cy[,distortion...]");
    if (v.size() < 4) throw BadInput(place + ": fewer than the four numbers fx,fy,cx,cy");
    Camera camera;
    camera.fx = v[0];
    camera.fy = v[1];
    camera.cx = v[2];
    camera.cy = v[3];
    SetDistortion({v.begin() + 4, v.end()}, false, place, camera);
    return CheckedCamera(camera, place);
  } catch (const Error& e) {
    throw std::invalid_argument(std::string(e.what()) +
                                "; give an existing calibration file, or "
                                "fx,fy,cx,cy[,k1,k2,p1,p2[,k3]]");
  }
}

Camera ReadCamera(const std::string& camera) {
  std::error_code error;
  const fs::path file(camera);
  const bool looks_like_list = camera.find(',') != std::string::npos && !fs::exists(file, error);
  if (looks_like_list) return ParseCameraList(camera);
  const std::string extension = ToLower(file.extension().string());
  if (extension == ".yaml" || extension == ".yml") return ReadOpenCvYaml(file);
  return ReadIntrinsicsText(file);
}

std::optional<fs::path> FindCalibration(const fs::path& folder) {
  for (const char* name : {"camera.yaml",
                           "camera.yml",
                           "calibration.yaml",
                           "calibration.yml",
                           "intrinsics.yaml",
                           "intrinsics.yml",
                           "intrinsics.txt"}) {
    std::error_code error;
    if (fs::is_regular_file(folder / name, error)) return folder / name;
  }
  return std::nullopt;
}

}  // namespace livemvs
