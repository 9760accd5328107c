#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "livemvs/core/frame.h"

namespace livemvs {

/// A converged seed: one point of the model.
struct Point {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< In the world [scene].
  Eigen::Vector3f normal =
      Eigen::Vector3f::Zero();  ///< Unit; towards the camera where only that is known.
  Rgb color{};
  float sigma = 0;          ///< Standard deviation of the depth [scene].
  float inlier_ratio = 0;   ///< Mean of the Beta posterior, a / (a + b).
  std::uint16_t views = 0;  ///< Frames whose measurement agreed.
  std::uint8_t level = 0;   ///< Of the image pyramid, on which it was matched.
  std::uint8_t lean = 0;    ///< At which side its patch has its texture, see core/lean.h.
  float footprint = 0;      ///< Width on the surface of a pixel of the image it was matched in
                            ///< [scene].
  std::int32_t frame = -1;  ///< Index of the frame in which it converged, whose camera saw it; -1:
                            ///< unknown.
};

/// A frame's index as Point::frame holds it; -1 where it does not fit.
inline std::int32_t FrameNumber(std::int64_t index) {
  return index >= 0 && index <= std::numeric_limits<std::int32_t>::max()
             ? static_cast<std::int32_t>(index)
             : -1;
}

using PointCloud = std::vector<Point>;

/// An axis-aligned box in the world. [scene]
struct Box {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Zero();

  bool Contains(const Eigen::Vector3d& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  /// The box with each side that much further out.
  Box Grown(double by) const { return {min.array() - by, max.array() + by}; }
};

}  // namespace livemvs
