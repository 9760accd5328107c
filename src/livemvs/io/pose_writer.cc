#include "livemvs/io/pose_writer.h"

#include <Eigen/Geometry>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>
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

std::string ColmapCamera(std::size_t id, const Camera& c) {
  const std::string model = ModelName(c);
  const int terms = model == "PINHOLE" ? 0 : model == "FULL_OPENCV" ? 8 : 4;
  std::string line = std::to_string(id) + " " + model + " " + std::to_string(c.width) + " " +
                     std::to_string(c.height);
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

bool Same(const Camera& a, const Camera& b) {
  return a.model == b.model && a.width == b.width && a.height == b.height && a.fx == b.fx &&
         a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.distortion == b.distortion;
}

// Number of a camera among others, from 1; one more than they are, where it is new.
std::size_t CameraId(const std::vector<Camera>& cameras, const Camera& camera) {
  std::size_t id = 0;
  while (id < cameras.size() && !Same(cameras[id], camera)) ++id;
  return id + 1;
}

void CheckCameras(const std::vector<PosedImage>& images) {
  for (const PosedImage& image : images) {
    if (image.camera.fy < 0) {
      throw std::invalid_argument(image.image +
                                  ": its camera has a negative fy (the picture is upside down), "
                                  "which COLMAP and transforms.json cannot hold; turn the "
                                  "pictures round first");
    }
  }
}

std::vector<PosedImage> WithCamera(const Camera& camera, const std::vector<TrackedPose>& poses) {
  std::vector<PosedImage> images;
  images.reserve(poses.size());
  for (const TrackedPose& pose : poses) {
    images.push_back({pose.image, camera, pose.cam_from_world});
  }
  return images;
}

// JSON is UTF-8, file names need not be.
std::string Dump(const json& all, const fs::path& file) {
  try {
    return all.dump(1);
  } catch (const json::type_error&) {
    throw std::invalid_argument(file.string() +
                                ": the name of a picture is not UTF-8, as JSON must be; rename it");
  }
}

std::string ColmapImages(const std::vector<PosedImage>& images,
                         const std::vector<Camera>& cameras) {
  std::string lines;
  int id = 0;
  for (const PosedImage& image : images) {
    const Eigen::Quaterniond q(image.cam_from_world.rotation);
    const Eigen::Vector3d& t = image.cam_from_world.translation;
    lines += std::to_string(++id) + Row({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) + " " +
             std::to_string(CameraId(cameras, image.camera)) + " " + image.image + "\n\n";
  }
  return lines;
}

void WriteColmapPoints(const fs::path& path, const PointCloud& cloud) {
  AtomicFile file(path);
  file.Write("# POINT3D_ID X Y Z R G B ERROR TRACK[]: no tracks, errors not known\n");
  char line[160];
  std::size_t id = 0;
  for (const Point& p : cloud) {
    const int length = std::snprintf(line,
                                     sizeof line,
                                     "%zu %.9g %.9g %.9g %d %d %d -1\n",
                                     ++id,
                                     p.position.x(),
                                     p.position.y(),
                                     p.position.z(),
                                     p.color[0],
                                     p.color[1],
                                     p.color[2]);
    file.Write(line, static_cast<std::size_t>(length));
  }
  file.Commit();
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
  if (poses.empty()) {  // the calibration is worth keeping all the same
    json all = TransformsHead(camera);
    all["frames"] = json::array();
    WriteText(file, all.dump(1) + "\n");
    return;
  }
  WriteTransforms(file, WithCamera(camera, poses), "");
}

void WriteTransforms(const fs::path& file,
                     const std::vector<PosedImage>& images,
                     const std::string& ply_file_path) {
  CheckCameras(images);
  bool shared = !images.empty();
  for (const PosedImage& image : images) shared = shared && Same(image.camera, images[0].camera);
  json all = shared ? TransformsHead(images[0].camera) : json::object();
  if (!ply_file_path.empty()) all["ply_file_path"] = ply_file_path;
  all["frames"] = json::array();
  for (const PosedImage& image : images) {
    json frame = shared ? json::object() : TransformsHead(image.camera);
    frame["file_path"] = image.image;
    frame["transform_matrix"] = OpenGlMatrix(image.cam_from_world);
    all["frames"].push_back(std::move(frame));
  }
  WriteText(file, Dump(all, file) + "\n");
}

void WriteColmapText(const fs::path& folder,
                     const Camera& camera,
                     const std::vector<TrackedPose>& poses) {
  MakeFolder(folder);
  WriteText(folder / "points3D.txt", "# no points\n");
  WriteText(folder / "images.txt", ColmapImages(WithCamera(camera, poses), {camera}));
  WriteText(folder / "cameras.txt", ColmapCamera(1, camera));
}

void WriteColmapText(const fs::path& folder,
                     const std::vector<PosedImage>& images,
                     const PointCloud& cloud) {
  CheckCameras(images);
  MakeFolder(folder);
  std::vector<Camera> cameras;
  for (const PosedImage& image : images) {
    if (CameraId(cameras, image.camera) > cameras.size()) cameras.push_back(image.camera);
  }
  std::string camera_lines;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    camera_lines += ColmapCamera(i + 1, cameras[i]);
  }
  WriteColmapPoints(folder / "points3D.txt", cloud);
  WriteText(folder / "images.txt", ColmapImages(images, cameras));
  WriteText(folder / "cameras.txt", camera_lines);
}

}  // namespace livemvs
