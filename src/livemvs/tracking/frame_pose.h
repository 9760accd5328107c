#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/image.h"
#include "livemvs/tracking/board_tracker.h"
#include "livemvs/tracking/corner_search.h"
#include "livemvs/tracking/sheet_pattern.h"

namespace livemvs {

/// The board in one picture.
struct FramePose {
  PoseFit fit;
  std::vector<FoundCorner> corners;
  std::vector<PointObservation> observations;  ///< As many.
  double sigma_px = 0;                         ///< As in PoseEstimate.
  double blur_px = 0;                          ///< Likewise.
};

/// A pose, or why there is none.
struct FrameResult {
  std::optional<FramePose> pose;
  std::string problem;
};

/// How far the picture moved during the exposure, from the width of the edges; 0 without corners.
/// [px]
double MotionBlur(const std::vector<FoundCorner>& corners);

/// Finds the pose of single pictures. Not thread-safe: the marker detector is not.
class FramePoser {
 public:
  FramePoser(const Board& board, const TrackerOptions& options);

  /// From a prediction that is off by no more than max_motion_px.
  FrameResult Track(ImageView<std::uint8_t> image,
                    const Projector& projector,
                    const Rigid3d& predicted) const;

  /// From nothing.
  FrameResult Detect(ImageView<std::uint8_t> image, const Projector& projector);

  /// The corners around the markers that are detected, without knowledge of the camera.
  std::vector<FoundCorner> DetectCorners(ImageView<std::uint8_t> image);

  const CornerSearch& search() const { return search_; }

 private:
  FrameResult Refine(ImageView<std::uint8_t> image,
                     const Projector& projector,
                     const Rigid3d& start) const;
  std::string Judge(ImageView<std::uint8_t> image,
                    const Projector& projector,
                    FramePose* pose) const;
  double WorstSigma(const Projector& projector, const PoseFit& fit) const;

  TrackerOptions options_;
  CornerSearch search_;
  SheetPattern pattern_;
  MarkerDetector detector_;
  Box room_;
  double square_ = 0;
};

}  // namespace livemvs
