#pragma once

#include <future>
#include <optional>
#include <string>

#include "livemvs/core/camera.h"
#include "livemvs/tracking/calibrator.h"

namespace livemvs {

/// Finds focal length, k1 and k2 while frames come, and improves them in the background: the bundle
/// adjustment over key frames runs in another thread, and its result is taken over a fixed number
/// of frames later, so that a recording gives the same poses each time.
class SelfCalibration {
 public:
  SelfCalibration(int width, int height);

  /// Takes the corners of the next frame (none: not seen).
  /// @return A camera that is to be used from the next frame on, where there is a new one.
  std::optional<Camera> Update(const CalibrationView& view);

  /// Why there is no camera yet, for people.
  const std::string& problem() const { return problem_; }

  /// The last calibration that was good.
  const std::optional<Calibration>& calibration() const { return calibration_; }

 private:
  std::optional<Camera> Take(const Calibration& calibration);

  Calibrator calibrator_;
  std::optional<Calibration> calibration_;
  std::string problem_;
  int added_ = 0;  // views since the last adjustment
  std::future<Calibration> running_;
  int frames_to_wait_ = 0;
  bool finished_ = false;
};

}  // namespace livemvs
