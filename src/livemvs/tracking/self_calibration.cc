#include "livemvs/tracking/self_calibration.h"

#include <cmath>

namespace livemvs {
namespace {

constexpr int kViewsBetween = 2;          // new ones before another first attempt
constexpr int kViewsBetweenLater = 5;     // and before another improvement
constexpr int kFramesToWait = 15;         // for the background's result
constexpr double kGoodFocalSigma = 1e-4;  // where improving ends [relative]

CalibratorOptions ForSelfCalibration() {
  CalibratorOptions options;
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

SelfCalibration::SelfCalibration(int width, int height)
    : calibrator_(width, height, ForSelfCalibration()),
      problem_("board not seen; it is needed to calibrate the camera, too") {}

std::optional<Camera> SelfCalibration::Take(const Calibration& calibration) {
  if (!calibration.problem.empty()) {
    if (!calibration_) problem_ = "calibrating the camera: " + calibration.problem;
    return std::nullopt;
  }
  calibration_ = calibration;
  finished_ = calibration.sigma[0] < kGoodFocalSigma * calibration.camera.fx;
  return calibration.camera;
}

std::optional<Camera> SelfCalibration::Update(const CalibrationView& view) {
  if (running_.valid()) {
    if (--frames_to_wait_ > 0) return std::nullopt;
    return Take(running_.get());
  }
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
