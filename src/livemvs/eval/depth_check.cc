#include "livemvs/eval/depth_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr int kBorder = 2;  ///< Pixels next to the edge are not used.
constexpr std::size_t kMaxViews = 1000000;

/// The smallest z error in the 3 x 3 pixels about (x, y), with its sign; nothing where nothing was
/// measured.
std::optional<double> SmallestError(
    double z, const Image<std::uint16_t>& depth, int x, int y, const DepthCheckOptions& options) {
  std::optional<double> best;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      const double measured = depth(u, v) * options.unit;
      if (!(measured > 0) || measured > options.depth_max) continue;
      const double error = z - measured;
      if (!best || std::abs(error) < std::abs(*best)) best = error;
    }
  }
  return best;
}

DepthView ParseDepthView(const std::string& line, const std::string& place) {
  constexpr std::size_t kNumbers = 22;
  std::istringstream text(line);
  DepthView view;
  std::array<double, kNumbers> v{};
  text >> view.name;
  for (double& x : v) {
    if (!(text >> x) || !std::isfinite(x)) {
      throw BadInput(place +
                     ": expected a name and 22 finite numbers: w h fx fy cx cy k1 k2 p1 p2 "
                     "R(9) t(3)");
    }
  }
  if (!(v[0] >= 1 && v[0] <= 65536 && v[1] >= 1 && v[1] <= 65536)) {
    throw BadInput(place + ": the image size is not from 1 to 65536");
  }
  Camera& camera = view.camera;
  camera.width = static_cast<int>(v[0]);
  camera.height = static_cast<int>(v[1]);
  camera.fx = v[2];
  camera.fy = v[3];
  camera.cx = v[4];
  camera.cy = v[5];
  for (std::size_t i = 0; i < 4; ++i) camera.distortion[i] = v[6 + i];
  if (v[6] != 0 || v[7] != 0 || v[8] != 0 || v[9] != 0) camera.model = CameraModel::kBrownConrady;
  try {
    camera.Check();
  } catch (const std::invalid_argument& e) {
    throw BadInput(place + ": " + e.what());
  }
  Eigen::Matrix3d& rotation = view.cam_from_world.rotation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = v[static_cast<std::size_t>(10 + i)];
  view.cam_from_world.translation = {v[19], v[20], v[21]};
  const double skew = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(skew < 1e-3)) throw BadInput(place + ": R is not a rotation");
  return view;
}

}  // namespace

void DepthCheckOptions::Check() const {
  if (!(z_min >= 0 && z_min < z_max)) {
    throw std::invalid_argument("z_min, z_max: must be 0 <= z_min < z_max");
  }
  if (!(tolerance > 0)) throw std::invalid_argument("tolerance: must be > 0");
  if (!(unit > 0 && std::isfinite(unit))) throw std::invalid_argument("unit: must be > 0");
}

double DepthCheckResult::MedianError() const {
  if (errors.empty()) return 0;
  std::vector<float> sorted = errors;
  const std::size_t half = sorted.size() / 2;
  std::nth_element(
      sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(half), sorted.end());
  if (sorted.size() % 2 == 1) return sorted[half];
  const float below =
      *std::max_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(half));
  return (static_cast<double>(below) + sorted[half]) / 2;
}

double DepthCheckResult::FloatingShare() const {
  return static_cast<double>(floating) /
         static_cast<double>(std::max<std::int64_t>(agree + floating, 1));
}

void CompareWithDepth(const PointCloud& cloud,
                      const DepthView& view,
                      const Image<std::uint16_t>& depth,
                      const DepthCheckOptions& options,
                      DepthCheckResult* result) {
  options.Check();
  if (depth.width() != view.camera.width || depth.height() != view.camera.height) {
    throw std::invalid_argument(
        "CompareWithDepth: " + view.name + " is " + std::to_string(depth.width()) + " x " +
        std::to_string(depth.height()) + ", its camera " + std::to_string(view.camera.width) +
        " x " + std::to_string(view.camera.height));
  }
  const Projector projector(view.camera);
  result->points = 0;
  ++result->frames;
  for (const Point& p : cloud) {
    if (!p.position.allFinite()) continue;
    ++result->points;
    const Eigen::Vector3d in_cam = view.cam_from_world * p.position.cast<double>();
    if (!(in_cam.z() > options.z_min && in_cam.z() < options.z_max)) continue;
    const auto pixel = projector.Project(in_cam);
    if (!pixel || !view.camera.Contains(*pixel)) continue;
    const int x = static_cast<int>(std::nearbyint(pixel->x()));
    const int y = static_cast<int>(std::nearbyint(pixel->y()));
    if (x < kBorder || y < kBorder || x >= depth.width() - kBorder ||
        y >= depth.height() - kBorder) {
      continue;
    }
    const std::optional<double> error = SmallestError(in_cam.z(), depth, x, y, options);
    if (!error) continue;
    if (std::abs(*error) < options.tolerance) {
      ++result->agree;
      result->errors.push_back(static_cast<float>(std::abs(*error)));
    } else if (*error < 0) {
      ++result->floating;
    } else {
      ++result->behind;
    }
  }
}

std::vector<DepthView> ReadDepthViews(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) {
    throw BadInput(file.string() +
                   ": cannot be opened; the folder must hold it beside the depth pictures");
  }
  std::vector<DepthView> views;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    views.push_back(ParseDepthView(line, file.string() + ": line " + std::to_string(number)));
    if (views.size() > kMaxViews) throw BadInput(file.string() + ": more than a million lines");
  }
  if (views.empty()) throw BadInput(file.string() + ": names no depth picture");
  return views;
}

}  // namespace livemvs
