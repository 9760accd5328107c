#include "livemvs/tracking/calibration_guide.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "livemvs/tracking/corner_search.h"

namespace livemvs {
namespace {

constexpr double kUsualFocal = 0.95;  // [widths]; a slant need not be known well

// The sheet's normal in the camera, towards it, from a homography and a usual lens: the first two
// columns of K⁻¹ H are the sheet's axes, up to scale.
std::optional<Eigen::Vector3d> Normal(const CalibrationView& view, int width, int height) {
  std::vector<Eigen::Vector2d> points, rays;
  const double focal = kUsualFocal * width;
  const Eigen::Vector2d middle(0.5 * (width - 1), 0.5 * (height - 1));
  for (const PointObservation& o : view.observations) {
    points.emplace_back(o.point.head<2>());
    rays.emplace_back((o.pixel - middle) / focal);
  }
  const auto h = FitHomography(points, rays);
  if (!h) return std::nullopt;
  Eigen::Vector3d normal = h->col(0).cross(h->col(1));
  const double length = normal.norm();
  if (!(length > 1e-12)) return std::nullopt;
  normal /= length;
  return normal.z() > 0 ? -normal : normal;
}

}  // namespace

CalibrationGuide::CalibrationGuide(int width, int height, const CalibratorOptions& options)
    : width_(width), height_(height), options_(options) {}

void CalibrationGuide::Add(const CalibrationView& view) {
  ++views_;
  if (const auto normal = Normal(view, width_, height_)) {
    slant_sideways_ |= std::abs(normal->x()) > kSlant;
    slant_upwards_ |= std::abs(normal->y()) > kSlant;
  }
  for (const PointObservation& o : view.observations) {
    const int x = std::clamp(static_cast<int>(o.pixel.x() * kParts / width_), 0, kParts - 1);
    const int y = std::clamp(static_cast<int>(o.pixel.y() * kParts / height_), 0, kParts - 1);
    ++corners_[y * kParts + x];
  }
}

std::string CalibrationGuide::EmptyPart() const {
  static constexpr const char* kNames[kParts * kParts] = {"upper left corner",
                                                          "upper edge",
                                                          "upper right corner",
                                                          "left edge",
                                                          "middle",
                                                          "right edge",
                                                          "lower left corner",
                                                          "lower edge",
                                                          "lower right corner"};
  const auto least = std::min_element(corners_.begin(), corners_.end());
  return *least < kEnoughCorners ? kNames[least - corners_.begin()] : "";
}

std::string CalibrationGuide::Missing() const {
  if (!slant_upwards_) {
    return "film the board at a slant: from lower down, its far edge further away than its near "
           "one";
  }
  if (!slant_sideways_) {
    return "film the board at a slant sideways: its left or right edge nearer, or the camera held "
           "upright";
  }
  const std::string part = EmptyPart();
  if (!part.empty()) return "bring the board to the " + part + " of the picture";
  const int enough = std::max(kEnoughViews, options_.min_views);
  if (views_ < enough) {
    return std::to_string(enough - views_) + " more views: nearer, further away, other slants";
  }
  return {};
}

std::string CalibrationGuide::Next(const CalibrationView& latest) const {
  const std::string missing = Missing();
  if (missing.empty()) return missing;
  if (static_cast<int>(latest.observations.size()) < options_.min_corners) {
    return "the board is not seen: bring it into the picture, sharp and well lit";
  }
  if (latest.blur_px > options_.max_blur_px) return "more slowly: the picture is blurred";
  return missing;
}

}  // namespace livemvs
