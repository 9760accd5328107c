#include "livemvs/io/transforms.h"

#include <cmath>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/dataset_check.h"
#include "livemvs/io/json_file.h"

namespace livemvs {
namespace {

using nlohmann::json;

// The place of a value in the file, and its frame before the whole file where both may state it.
class Fields {
 public:
  Fields(const json& frame, const json& all, std::string place)
      : frame_(frame), all_(all), place_(std::move(place)) {}

  const std::string& place() const { return place_; }

  const json* Find(const char* key) const {
    for (const json* object : {&frame_, &all_}) {
      const auto found = object->find(key);
      if (found != object->end() && !found->is_null()) return &*found;
    }
    return nullptr;
  }

  std::optional<double> Number(const char* key) const {
    const json* value = Find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_number() || !std::isfinite(value->get<double>())) {
      throw BadInput(place_ + ": '" + key + "' is not a finite number");
    }
    return value->get<double>();
  }

  std::string Text(const char* key) const {
    const json* value = Find(key);
    if (value == nullptr) return {};
    if (!value->is_string()) throw BadInput(place_ + ": '" + std::string(key) + "' is not a text");
    return value->get<std::string>();
  }

 private:
  const json& frame_;
  const json& all_;
  std::string place_;
};

int ReadSize(const Fields& fields, const char* key) {
  const std::optional<double> value = fields.Number(key);
  if (!value) return 0;
  constexpr double kMaxSize = 32768;
  if (*value < 1 || *value > kMaxSize || *value != std::floor(*value)) {
    throw BadInput(fields.place() + ": '" + key + "' is not an image size in pixels");
  }
  return static_cast<int>(*value);
}

void ReadModel(const Fields& fields, Camera& camera) {
  std::string name = fields.Text("camera_model");
  const json* fisheye = fields.Find("is_fisheye");
  if (name.empty() && fisheye != nullptr && fisheye->is_boolean() && fisheye->get<bool>()) {
    name = "OPENCV_FISHEYE";
  }
  const auto k = [&](const char* key) { return fields.Number(key).value_or(0); };
  if (name == "OPENCV_FISHEYE") {
    camera.model = CameraModel::kKannalaBrandt;
    camera.distortion = {k("k1"), k("k2"), k("k3"), k("k4")};
    return;
  }
  const bool rational = name == "FULL_OPENCV";
  const bool brown = name.empty() || name == "OPENCV" || name == "PINHOLE" ||
                     name == "SIMPLE_PINHOLE" || name == "SIMPLE_RADIAL" || name == "RADIAL";
  if (!rational && !brown) {
    throw BadInput(fields.place() + ": the camera model '" + name.substr(0, 40) +
                   "' is not supported; undistort the images, or use PINHOLE, OPENCV, FULL_OPENCV "
                   "or OPENCV_FISHEYE");
  }
  camera.model = CameraModel::kBrownConrady;
  camera.distortion = {k("k1"), k("k2"), k("p1"), k("p2"), k("k3")};
  if (rational) {
    camera.distortion[5] = k("k4");
    camera.distortion[6] = k("k5");
    camera.distortion[7] = k("k6");
  } else if (k("k4") != 0) {
    throw BadInput(fields.place() +
                   ": 'k4' with this camera model is a fourth radial term, which is not supported; "
                   "calibrate with k1 k2 k3 p1 p2");
  }
}

// Focal lengths and principal point for an image of `camera`'s size, in the file's convention.
void ReadIntrinsics(const Fields& fields, Camera& camera) {
  std::optional<double> fx = fields.Number("fl_x");
  std::optional<double> fy = fields.Number("fl_y");
  const std::optional<double> angle_x = fields.Number("camera_angle_x");
  const std::optional<double> angle_y = fields.Number("camera_angle_y");
  const auto focal = [&](double size, double angle, const char* key) {
    if (!(angle > 0 && angle < M_PI)) {
      throw BadInput(fields.place() + ": '" + key + "' is not an angle within 0 ... pi");
    }
    return 0.5 * size / std::tan(0.5 * angle);
  };
  const bool needs_width = (!fx && angle_x) || !fields.Number("cx");
  const bool needs_height = (!fy && angle_y) || !fields.Number("cy");
  if ((needs_width || needs_height) && camera.width == 0) {
    throw BadInput(fields.place() +
                   ": neither fl_x, cx, cy nor the image size w, h is stated; add 'w' and 'h'");
  }
  if (!fx && angle_x) fx = focal(camera.width, *angle_x, "camera_angle_x");
  if (!fy && !fields.Number("fl_x") && angle_y) {
    fy = focal(camera.height, *angle_y, "camera_angle_y");
  }
  if (!fx) throw BadInput(fields.place() + ": neither 'fl_x' nor 'camera_angle_x' is stated");
  camera.fx = *fx;
  camera.fy = fy.value_or(*fx);
  // The file's centre of the top-left pixel is (0.5, 0.5), ours is (0, 0).
  camera.cx = fields.Number("cx").value_or(0.5 * camera.width) - 0.5;
  camera.cy = fields.Number("cy").value_or(0.5 * camera.height) - 0.5;
}

Rigid3d ReadPose(const json& frame, const std::string& place, const PoseChecker& checker) {
  const auto matrix = frame.find("transform_matrix");
  const auto bad = [&] {
    return BadInput(place + ": 'transform_matrix' is not 4 (or 3) rows of 4 finite numbers");
  };
  if (matrix == frame.end() || !matrix->is_array() || matrix->size() < 3 || matrix->size() > 4) {
    throw bad();
  }
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (std::size_t row = 0; row < matrix->size(); ++row) {
    const json& values = (*matrix)[row];
    if (!values.is_array() || values.size() != 4) throw bad();
    for (std::size_t col = 0; col < 4; ++col) {
      if (!values[col].is_number() || !std::isfinite(values[col].get<double>())) throw bad();
      m(static_cast<int>(row), static_cast<int>(col)) = values[col].get<double>();
    }
  }
  constexpr double kTolerance = 1e-6;
  if ((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kTolerance) {
    throw BadInput(place + ": the last row of 'transform_matrix' is not 0 0 0 1");
  }
  return FromOpenGl({checker.FromMatrix(m.topLeftCorner<3, 3>(), place), m.topRightCorner<3, 1>()});
}

void NoteAppliedTransform(const json& all, const std::filesystem::path& file) {
  if (all.contains("applied_transform") || all.contains("applied_scale")) {
    LogInfo(file.string() +
            ": applied_transform/applied_scale are not undone; results are in the "
            "file's own world");
  }
}

}  // namespace

ImageSet ReadTransforms(const std::filesystem::path& file) {
  const json all = ReadJsonFile(file, {.what = "transforms.json"});
  if (!all.is_object() || !all.contains("frames") || !all["frames"].is_array()) {
    throw BadInput(file.string() + ": has no list 'frames'; this is no transforms.json");
  }
  NoteAppliedTransform(all, file);
  ImageSet set;
  set.format = "transforms.json";
  set.file = file;
  set.root = set.image_folder = file.parent_path().empty() ? "." : file.parent_path();
  const PoseChecker checker;
  for (std::size_t i = 0; i < all["frames"].size(); ++i) {
    const json& frame = all["frames"][i];
    ImageEntry image;
    image.place = file.string() + ": frame " + std::to_string(i);
    if (!frame.is_object()) throw BadInput(image.place + ": is not an object");
    const Fields fields(frame, all, image.place);
    image.name = fields.Text("file_path");
    if (image.name.empty()) throw BadInput(image.place + ": has no 'file_path'");
    image.camera.width = ReadSize(fields, "w");
    image.camera.height = ReadSize(fields, "h");
    if ((image.camera.width == 0) != (image.camera.height == 0)) {
      throw BadInput(image.place + ": only one of 'w' and 'h' is stated");
    }
    ReadModel(fields, image.camera);
    ReadIntrinsics(fields, image.camera);
    image.camera = CheckedCamera(image.camera, image.place);
    image.cam_from_world = ReadPose(frame, image.place, checker);
    set.images.push_back(std::move(image));
  }
  return set;
}

}  // namespace livemvs
