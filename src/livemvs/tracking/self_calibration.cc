#include "livemvs/tracking/self_calibration.h"

#include <cmath>

namespace livemvs {
namespace {

constexpr int kViewsBetween = 2;          // new ones before another first attempt
constexpr int kViewsBetweenLater = 5;     // and before another improvement
constexpr int kFramesToWait = 15;         // for the background's result
constexpr double kGoodFocalSigma = 1e-4;  // where improving ends [relative]

CalibratorOptions OptionsFor(const SelfCalibration::Task& task) {
  CalibratorOptions options;
  options.camera = task.camera;
  options.bend = task.bend;
  if (task.given && task.given->model == CameraModel::kKannalaBrandt)
    options.model = task.given->model;
  options.distortion_terms = 2;
  options.principal_point = false;
  options.min_views = 6;
  options.min_difference = 0.02;
  options.max_rms_px = 1;
  options.max_focal_sigma = 0.003;
  options.min_coverage = 0;  // what is seen is what matters here
  return options;
}

}  // namespace

SelfCalibration::SelfCalibration(int width, int height, const Task& task)
    : task_(task),
      calibrator_(width, height, OptionsFor(task)),
      problem_("board not seen; it is needed to calibrate the camera, too") {
  if (!task.given) return;
  calibration_.emplace();
  calibration_->camera = *task.given;
  // A lens that was taken to have no distortion may have some.
  CameraModel& model = calibration_->camera.model;
  if (task.camera && model == CameraModel::kPinhole) model = CameraModel::kBrownConrady;
}

std::optional<Calibration> SelfCalibration::Take(const Calibration& calibration) {
  if (!calibration.problem.empty()) {
    if (!calibration_) problem_ = "calibrating the camera: " + calibration.problem;
    return std::nullopt;
  }
  calibration_ = calibration;
  finished_ = task_.camera && calibration.sigma[0] < kGoodFocalSigma * calibration.camera.fx;
  return calibration_;
}

std::optional<Calibration> SelfCalibration::Update(CalibrationView view) {
  if (running_.valid()) {
    if (--frames_to_wait_ > 0) return std::nullopt;
    return Take(running_.get());
  }
  // The bend is always estimated anew, from the flat sheet.
  for (PointObservation& o : view.observations) o.point.z() = 0;
  if (finished_ || !calibrator_.Add(view)) return std::nullopt;
  ++added_;
  if (!calibration_) {
    problem_ = "calibrating the camera: move it around the board, tilted to all sides";
    if (added_ < kViewsBetween) return std::nullopt;
    added_ = 0;
    return Take(calibrator_.Solve());
  }
  if (added_ < kViewsBetweenLater) return std::nullopt;
  added_ = 0;
  frames_to_wait_ = kFramesToWait;
  running_ = std::async(
      std::launch::async,
      [calibrator = calibrator_, start = calibration_->camera] { return calibrator.Solve(start); });
  return std::nullopt;
}

}  // namespace livemvs
