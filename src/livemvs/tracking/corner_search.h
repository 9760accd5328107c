#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/pose.h"
#include "livemvs/tracking/board.h"
#include "livemvs/tracking/corner_fit.h"
#include "livemvs/tracking/marker_detector.h"
#include "livemvs/tracking/pose_fit.h"

namespace livemvs {

/// A corner of the board found in a picture.
struct FoundCorner {
  int index = 0;  ///< Into CornersOf(board).
  CornerFit fit;
};

/// Looks for all corners of a board at their expected places.
class CornerSearch {
 public:
  explicit CornerSearch(const Board& board);

  /// How a pose lets each corner be seen; nothing where it is outside of the picture.
  std::vector<std::optional<CornerView>> ViewsFromPose(const Projector& projector,
                                                       const Rigid3d& cam_from_world) const;

  /// How the markers around each corner let it be seen, without knowledge of the camera; nothing
  /// where no marker is near.
  std::vector<std::optional<CornerView>> ViewsFromMarkers(
      const std::vector<DetectedMarker>& markers) const;

  /// Fits all corners that are expected. @param every  Only every so many-th of them.
  std::vector<FoundCorner> Find(ImageView<std::uint8_t> image,
                                const std::vector<std::optional<CornerView>>& views,
                                const CornerFitOptions& options,
                                int every = 1) const;

  /// Finds the corners around detected markers: coarsely, and again about what was found.
  std::vector<FoundCorner> FindByMarkers(ImageView<std::uint8_t> image,
                                         const std::vector<DetectedMarker>& markers,
                                         const CornerFitOptions& options) const;

  /// For FitPose.
  std::vector<PointObservation> Observations(const std::vector<FoundCorner>& found) const;

  const std::vector<BoardCorner>& corners() const { return corners_; }

 private:
  std::vector<BoardCorner> corners_;
  std::vector<BoardMarker> markers_;
  CornerGeometry geometry_;
  double square_ = 0;
};

/// The homography that maps points of the plane to pixels, by least squares over four or more, or
/// nothing where they do not determine it.
std::optional<Eigen::Matrix3d> FitHomography(const std::vector<Eigen::Vector2d>& points,
                                             const std::vector<Eigen::Vector2d>& pixels);

}  // namespace livemvs
