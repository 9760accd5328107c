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
  /// What is to be found. With a camera given, it is where improvement starts.
  struct Task {
    std::optional<Camera> given;
    bool camera = true;
    bool bend = false;
  };

  SelfCalibration(int width, int height, const Task& task);

  /// Takes the corners of the next frame (none: not seen).
  /// @return What is to be used from the next frame on (camera and bend), where that is new.
  std::optional<Calibration> Update(CalibrationView view);

  /// Why there is no camera yet, for people.
  const std::string& problem() const { return problem_; }

  /// The last calibration that was good.
  const std::optional<Calibration>& calibration() const { return calibration_; }

 private:
  std::optional<Calibration> Take(const Calibration& calibration);

  Task task_;
  Calibrator calibrator_;
  std::optional<Calibration> calibration_;
  std::string problem_;
  int added_ = 0;  // views since the last adjustment
  std::future<Calibration> running_;
  int frames_to_wait_ = 0;
  bool finished_ = false;
};

}  // namespace livemvs
