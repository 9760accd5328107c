#include "livemvs/tracking/board_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "livemvs/tracking/frame_pose.h"
#include "livemvs/tracking/motion.h"
#include "livemvs/tracking/rolling_shutter.h"
#include "livemvs/tracking/self_calibration.h"

namespace livemvs {
namespace {

void RequireSetting(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("tracker: ") + what);
}

class BoardTracker : public PoseSource {
 public:
  BoardTracker(const Board& board, const std::optional<Camera>& camera, const TrackerOptions& o)
      : options_(o), poser_(board, o) {
    if (camera) camera_ = *camera;
    calibrated_ = camera.has_value();
  }

  PoseEstimate Estimate(const Picture& picture, double timestamp) override {
    TakeSize(picture);
    const ImageView<std::uint8_t> image = picture.grey.view();
    if (!projector_) return Calibrate(image);
    FrameResult result;
    if (const auto predicted = motion_.Predict(timestamp, options_.max_gap_seconds)) {
      result = poser_.Track(image, *projector_, *predicted);
    }
    if (!result.pose) result = poser_.Detect(image, *projector_);
    const PoseEstimate estimate = Report(result, timestamp);
    if (self_calibration_ && result.pose) {
      Use(self_calibration_->Update({result.pose->observations, result.pose->blur_px}));
    }
    return estimate;
  }

  Camera camera() const override { return camera_; }

 private:
  void TakeSize(const Picture& picture) {
    RequireSetting(!picture.grey.empty(), "the picture is empty");
    if (camera_.width == 0) {
      camera_.width = picture.width();
      camera_.height = picture.height();
    }
    if (camera_.width != picture.width() || camera_.height != picture.height()) {
      throw std::invalid_argument(
          "tracker: the picture has " + std::to_string(picture.width()) + " x " +
          std::to_string(picture.height()) + " pixels, the camera's calibration " +
          std::to_string(camera_.width) + " x " + std::to_string(camera_.height) +
          "; calibrate at the size that is filmed");
    }
    if (projector_ || self_calibration_) return;
    if (calibrated_) projector_.emplace(camera_);
    SelfCalibration::Task task;
    if (calibrated_) task.given = camera_;
    task.camera = !calibrated_ || options_.refine_camera;
    task.bend = options_.refine_sheet;
    if (task.camera || task.bend) {
      self_calibration_.emplace(picture.width(), picture.height(), task);
    }
  }

  // Before the camera is known.
  PoseEstimate Calibrate(ImageView<std::uint8_t> image) {
    const std::vector<FoundCorner> corners = poser_.DetectCorners(image);
    const CalibrationView view{poser_.search().Observations(corners), MotionBlur(corners)};
    Use(self_calibration_->Update(view));
    PoseEstimate estimate;
    estimate.observations = static_cast<int>(corners.size());
    estimate.problem = self_calibration_->problem();
    return estimate;
  }

  void Use(const std::optional<Calibration>& calibration) {
    if (!calibration) return;
    camera_ = calibration->camera;
    projector_.emplace(camera_);
    poser_.Bend(calibration->bend);
  }

  PoseEstimate Report(const FrameResult& result, double timestamp) {
    PoseEstimate estimate;
    if (!result.pose) {
      estimate.state = seen_before_ ? TrackingState::kLost : TrackingState::kSearching;
      estimate.problem = result.problem;
      return estimate;
    }
    const FramePose& pose = *result.pose;
    seen_before_ = true;
    if (const auto previous = motion_.Last(timestamp, options_.max_gap_seconds)) {
      rolling_.Add(camera_, pose.fit, pose.observations, *previous);
    }
    motion_.Add(timestamp, pose.fit.cam_from_world);
    estimate.rolling_readout = rolling_.Readout().value_or(0);
    estimate.state = TrackingState::kTracking;
    estimate.cam_from_world = pose.fit.cam_from_world;
    estimate.observations = pose.fit.inliers;
    estimate.rms_px = pose.fit.rms_px;
    estimate.sigma_px = pose.sigma_px;
    estimate.blur_px = pose.blur_px;
    return estimate;
  }

  TrackerOptions options_;
  FramePoser poser_;
  Camera camera_;
  bool calibrated_ = false;  // from the start
  std::optional<SelfCalibration> self_calibration_;
  std::optional<Projector> projector_;
  Motion motion_;
  RollingShutterWatch rolling_;
  bool seen_before_ = false;
};

}  // namespace

void TrackerOptions::Check() const {
  RequireSetting(min_corners >= 4, "min_corners must be at least 4");
  RequireSetting(max_rms_px > 0 && max_rms_px <= 10, "max_rms_px must be above 0, at most 10");
  RequireSetting(max_sigma_px > 0, "max_sigma_px must be positive");
  RequireSetting(max_motion_px >= 1 && max_motion_px <= 1000, "max_motion_px must be 1 to 1000");
  RequireSetting(max_gap_seconds > 0, "max_gap_seconds must be positive");
  RequireSetting(detect_width >= 160, "detect_width must be at least 160");
}

std::unique_ptr<PoseSource> MakeBoardTracker(const Board& board,
                                             const std::optional<Camera>& camera,
                                             const TrackerOptions& options) {
  board.Check();
  options.Check();
  if (camera) {
    Camera checked = *camera;
    if (checked.width == 0 && checked.height == 0) checked.width = checked.height = 1;
    checked.Check();
  }
  return std::make_unique<BoardTracker>(board, camera, options);
}

}  // namespace livemvs
