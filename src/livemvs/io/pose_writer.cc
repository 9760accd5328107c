#include "livemvs/io/pose_writer.h"

#include <Eigen/Geometry>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>

#include "livemvs/core/error.h"
#include "livemvs/io/atomic_file.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void WriteText(const fs::path& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

// Seventeen digits give a double back exactly.
std::string Number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string Row(std::initializer_list<double> values) {
  std::string row;
  for (const double value : values) row += " " + Number(value);
  return row;
}

// COLMAP's and nerfstudio's name of a camera's model.
std::string ModelName(const Camera& c) {
  if (c.model == CameraModel::kKannalaBrandt) return "OPENCV_FISHEYE";
  if (c.model == CameraModel::kPinhole) return "PINHOLE";
  for (int i = 4; i < 8; ++i) {
    if (c.distortion[i] != 0) return "FULL_OPENCV";
  }
  return "OPENCV";
}

std::string ColmapCamera(const Camera& c) {
  const std::string model = ModelName(c);
  const int terms = model == "PINHOLE" ? 0 : model == "FULL_OPENCV" ? 8 : 4;
  std::string line = "1 " + model + " " + std::to_string(c.width) + " " + std::to_string(c.height);
  line += Row({c.fx, c.fy, c.cx + 0.5, c.cy + 0.5});
  for (int i = 0; i < terms; ++i) line += " " + Number(c.distortion[i]);
  return line + "\n";
}

json TransformsHead(const Camera& c) {
  json head = {{"w", c.width},
               {"h", c.height},
               {"fl_x", c.fx},
               {"fl_y", c.fy},
               {"cx", c.cx + 0.5},
               {"cy", c.cy + 0.5},
               {"camera_model", ModelName(c)}};
  const auto& k = c.distortion;
  if (c.model == CameraModel::kKannalaBrandt) {
    head.update({{"k1", k[0]}, {"k2", k[1]}, {"k3", k[2]}, {"k4", k[3]}});
  } else if (c.model == CameraModel::kBrownConrady) {
    head.update({{"k1", k[0]}, {"k2", k[1]}, {"p1", k[2]}, {"p2", k[3]}});
    if (k[4] != 0) head["k3"] = k[4];
    if (head["camera_model"] == "FULL_OPENCV") {
      head.update({{"k4", k[5]}, {"k5", k[6]}, {"k6", k[7]}});
    }
  }
  return head;
}

json OpenGlMatrix(const Rigid3d& cam_from_world) {
  const Rigid3d w = cam_from_world.Inverse();
  json rows = json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({w.rotation(i, 0), -w.rotation(i, 1), -w.rotation(i, 2), w.translation[i]});
  }
  rows.push_back({0., 0., 0., 1.});
  return rows;
}

}  // namespace

void WritePoseRows(const fs::path& file, const std::vector<TrackedPose>& poses) {
  std::string text;
  for (const TrackedPose& pose : poses) {
    text += std::to_string(pose.frame);
    for (int i = 0; i < 3; ++i) {
      const auto r = pose.cam_from_world.rotation.row(i);
      text += Row({r[0], r[1], r[2], pose.cam_from_world.translation[i]});
    }
    text += "\n";
  }
  WriteText(file, text);
}

void WriteTransforms(const fs::path& file,
                     const Camera& camera,
                     const std::vector<TrackedPose>& poses) {
  json all = TransformsHead(camera);
  all["frames"] = json::array();
  for (const TrackedPose& pose : poses) {
    all["frames"].push_back(
        {{"file_path", pose.image}, {"transform_matrix", OpenGlMatrix(pose.cam_from_world)}});
  }
  WriteText(file, all.dump(1) + "\n");
}

void WriteColmapText(const fs::path& folder,
                     const Camera& camera,
                     const std::vector<TrackedPose>& poses) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw Error(ErrorKind::kOutOfResource,
                folder.string() + ": cannot make the folder: " + error.message());
  }
  std::string images;
  int id = 0;
  for (const TrackedPose& pose : poses) {
    const Eigen::Quaterniond q(pose.cam_from_world.rotation);
    const Eigen::Vector3d& t = pose.cam_from_world.translation;
    images += std::to_string(++id) + Row({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) +
              " 1 " + pose.image + "\n\n";
  }
  WriteText(folder / "points3D.txt", "# no points\n");
  WriteText(folder / "images.txt", images);
  WriteText(folder / "cameras.txt", ColmapCamera(camera));
}

}  // namespace livemvs
