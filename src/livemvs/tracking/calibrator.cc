#include "livemvs/tracking/calibrator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "livemvs/core/format_text.h"
#include "livemvs/tracking/corner_search.h"

namespace livemvs {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);
// The outline of a view is that of a square of this size about the middle of the world [m]: only
// differences between views matter.
constexpr double kOutline = 0.1;

void RequireOption(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("calibration: ") + what);
}

}  // namespace

void CalibratorOptions::Check() const {
  RequireOption(distortion_terms == 0 || distortion_terms == 2 || distortion_terms == 4 ||
                    distortion_terms == 5,
                "distortion_terms must be 0, 2, 4 or 5");
  RequireOption(min_views >= 3, "min_views must be at least 3");
  RequireOption(max_views >= min_views && max_views <= 500, "max_views must be min_views to 500");
  RequireOption(min_corners >= 6, "min_corners must be at least 6");
}

Calibrator::Calibrator(int width, int height, const CalibratorOptions& options)
    : width_(width), height_(height), options_(options) {
  options.Check();
  RequireOption(width > 0 && height > 0, "the picture has no size");
}

double Calibrator::Difference(const Outline& a, const Outline& b) const {
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += 0.25 * (a[k] - b[k]).norm();
  return sum;
}

double Calibrator::NearestDifference(const Outline& outline, std::size_t except) const {
  double nearest = 1e9;
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (i != except) nearest = std::min(nearest, Difference(outline, kept_[i].outline));
  }
  return nearest;
}

bool Calibrator::Add(const CalibrationView& view) {
  if (static_cast<int>(view.observations.size()) < options_.min_corners) return false;
  if (view.blur_px > options_.max_blur_px) return false;
  std::vector<Vector2d> points, pixels;
  for (const PointObservation& o : view.observations) {
    points.emplace_back(o.point.head<2>());
    pixels.push_back(o.pixel);
  }
  const auto homography = FitHomography(points, pixels);
  if (!homography) return false;
  Kept kept{view, {}, *homography};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d p = *homography * Eigen::Vector3d((k & 1) != 0 ? kOutline : -kOutline,
                                                            (k & 2) != 0 ? kOutline : -kOutline,
                                                            1);
    if (std::abs(p.z()) < 1e-12) return false;
    kept.outline[k] = p.head<2>() / (p.z() * width_);
  }
  if (NearestDifference(kept.outline, kNone) < options_.min_difference) return false;
  kept_.push_back(std::move(kept));
  if (views() <= options_.max_views) return true;
  // The view that says least beyond the others goes.
  std::size_t dullest = 0;
  for (std::size_t i = 1; i < kept_.size(); ++i) {
    if (NearestDifference(kept_[i].outline, i) <
        NearestDifference(kept_[dullest].outline, dullest)) {
      dullest = i;
    }
  }
  kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(dullest));
  return dullest != kept_.size();
}

// From the homographies, with square pixels and the axis through the middle of the picture: the
// images of the sheet's axes h1, h2 satisfy h1ᵀ ω h2 = 0 and h1ᵀ ω h1 = h2ᵀ ω h2, ω = diag(w, w,
// 1), w = 1 / f². And some usual ones, for views that do not say.
std::vector<double> Calibrator::FocalGuesses() const {
  double ab = 0, aa = 0;
  for (const Kept& kept : kept_) {
    Eigen::Matrix3d center = Eigen::Matrix3d::Identity();
    center(0, 2) = -0.5 * (width_ - 1);
    center(1, 2) = -0.5 * (height_ - 1);
    Eigen::Matrix3d h = center * kept.homography;
    h.topRows<2>() /= width_;
    h /= h.leftCols<2>().norm();
    const auto add = [&](double a, double b) {  // a w + b = 0
      aa += a * a;
      ab += a * b;
    };
    add(h.col(0).head<2>().dot(h.col(1).head<2>()), h(2, 0) * h(2, 1));
    add(0.5 * (h.col(0).head<2>().squaredNorm() - h.col(1).head<2>().squaredNorm()),
        0.5 * (h(2, 0) * h(2, 0) - h(2, 1) * h(2, 1)));
  }
  const bool fisheye = options_.model == CameraModel::kKannalaBrandt;
  std::vector<double> guesses = fisheye ? std::vector<double>{0.3 * width_, 0.5 * width_}
                                        : std::vector<double>{0.75 * width_, 1.1 * width_};
  const double w = aa > 0 ? -ab / aa : 0;
  if (w > 1e-3 && w < 100) guesses.insert(guesses.begin(), width_ / std::sqrt(w));
  return guesses;
}

Camera Calibrator::StartCamera(double focal) const {
  Camera camera;
  camera.model = options_.model;
  camera.width = width_;
  camera.height = height_;
  camera.fx = camera.fy = focal;
  camera.cx = 0.5 * (width_ - 1);
  camera.cy = 0.5 * (height_ - 1);
  return camera;
}

std::vector<BundleView> Calibrator::PosedViews(const Camera& camera) const {
  std::vector<BundleView> views;
  for (const Kept& kept : kept_) {
    std::optional<PoseFit> best;
    for (const Rigid3d& start : PlanarPoses(camera, kept.view.observations)) {
      // Nothing is an outlier yet: the camera is only guessed.
      const auto fit =
          FitPose(camera, kept.view.observations, start, {.floor_px = 2, .outlier_sigmas = 20});
      if (fit && (!best || fit->rms_px < best->rms_px)) best = fit;
    }
    if (best) views.push_back({best->cam_from_world, kept.view.observations});
  }
  return views;
}

// Level 0: the focal length; 1: with two terms of distortion; 2: all that is asked for.
BundleOptions Calibrator::Freedom(int level) const {
  BundleOptions bundle;
  bundle.bend = options_.bend && level == 2;
  if (!options_.camera) return bundle;
  bundle.free[0] = bundle.free[1] = true;
  const bool fisheye = options_.model == CameraModel::kKannalaBrandt;
  const int all = fisheye ? 4 : options_.distortion_terms;
  const int terms = level == 0 ? 0 : level == 1 ? std::min(2, all) : all;
  for (int i = 0; i < terms; ++i) bundle.free[4 + i] = true;
  if (level == 2 && options_.principal_point) {
    bundle.free[2] = bundle.free[3] = true;
    bundle.equal_focal = false;
  }
  return bundle;
}

Calibration Calibrator::Solve(const std::optional<Camera>& start) const {
  Calibration out;
  out.views = views();
  out.camera = start ? *start : StartCamera(0.95 * width_);
  out.problem = FormatText(
      "only %d different views of the board, %d are needed: move the camera "
      "around it, tilted to all sides",
      views(),
      options_.min_views);
  if (views() < options_.min_views) return out;
  BundleResult best;
  const std::vector<double> guesses =
      start ? std::vector<double>{start->FocalLength()} : FocalGuesses();
  for (const double focal : guesses) {
    Camera camera = start ? *start : StartCamera(focal);
    for (int level = start ? 2 : 0; level < 3; ++level) {
      const BundleResult result = AdjustBundle(camera, PosedViews(camera), Freedom(level));
      if (!result.converged) break;
      camera = result.camera;
      if (level < 2) continue;
      const bool better =
          !best.converged || (result.inliers >= best.inliers * 0.9 && result.rms_px < best.rms_px);
      if (better) best = result;
    }
    // The first guess comes from the views themselves; others are for where it fails.
    if (best.converged && best.rms_px < options_.max_rms_px) break;
  }
  out.problem = "no camera explains the views: is the board flat, and of this description?";
  if (!best.converged) return out;
  out.camera = best.camera;
  out.rms_px = best.rms_px;
  out.sigma = best.sigma;
  out.bend = best.bend;
  out.corners = best.inliers;
  out.view_rms_px = best.view_rms_px;
  for (const Rigid3d& pose : best.cam_from_world) {
    const double c = std::abs(pose.rotation.col(2).dot(pose.translation.normalized()));
    out.tilt_deg = std::max(out.tilt_deg, std::acos(std::min(c, 1.0)) * 180 / std::numbers::pi);
  }
  Cover(&out);
  out.problem = Judge(out);
  return out;
}

void Calibrator::Cover(Calibration* calibration) const {
  calibration->coverage_cells.assign(kCellColumns * kCellRows, 0);
  for (const Kept& kept : kept_) {
    for (const PointObservation& o : kept.view.observations) {
      const int x =
          std::clamp(static_cast<int>(o.pixel.x() * kCellColumns / width_), 0, kCellColumns - 1);
      const int y =
          std::clamp(static_cast<int>(o.pixel.y() * kCellRows / height_), 0, kCellRows - 1);
      ++calibration->coverage_cells[y * kCellColumns + x];
    }
  }
  const auto& cells = calibration->coverage_cells;
  calibration->coverage =
      static_cast<double>(cells.size() - std::count(cells.begin(), cells.end(), 0)) /
      static_cast<double>(cells.size());
}

std::string Calibrator::Judge(const Calibration& c) const {
  if (c.rms_px > options_.max_rms_px) {
    return FormatText(
        "the corners are off by %.2f px rms, at most %.2f is good: keep the board flat, "
        "focus and zoom fixed, and move slowly",
        c.rms_px,
        options_.max_rms_px);
  }
  const double focal_sigma = c.sigma[0] / c.camera.fx;
  if (focal_sigma > options_.max_focal_sigma) {
    return FormatText(
        "the focal length is known to %.2f %% only, %.2f %% is needed: film the board "
        "from more directions, tilted by 30 to 60 degrees",
        100 * focal_sigma,
        100 * options_.max_focal_sigma);
  }
  if (c.coverage < options_.min_coverage) {
    return FormatText(
        "corners were seen in %.0f %% of the picture only, %.0f %% are needed: bring the "
        "board to its borders, too",
        100 * c.coverage,
        100 * options_.min_coverage);
  }
  const Projector projector(c.camera);
  for (int k = 0; k < 4; ++k) {
    const Vector2d corner((k & 1) != 0 ? width_ - 1 : 0, (k & 2) != 0 ? height_ - 1 : 0);
    if (!projector.Unproject(corner)) {
      return "the distortion makes no sense at the picture's borders, where no corners were seen: "
             "bring the board there, or ask for fewer distortion terms";
    }
  }
  return {};
}

}  // namespace livemvs
