#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/pose.h"
#include "livemvs/tracking/board.h"

namespace livemvs {

/// How many of a board's markers a picture shows where a pose says they are.
struct MarkerCheck {
  int read = 0;       ///< Their bits are as printed.
  int different = 0;  ///< Something else is there: an object, or another part of the sheet.
};

/// Where the sheet is black and where it is white.
class SheetPattern {
 public:
  explicit SheetPattern(const Board& board);

  /// The pose moved sideways so that the pattern lies best on the picture, by up to `radius_px`.
  /// @return Nothing where the pattern does not stand out at any shift.
  std::optional<Rigid3d> Align(ImageView<std::uint8_t> image,
                               const Camera& camera,
                               const Rigid3d& predicted,
                               double radius_px) const;

  /// Reads the bits of the markers.
  MarkerCheck Check(ImageView<std::uint8_t> image,
                    const Projector& projector,
                    const Rigid3d& cam_from_world) const;

 private:
  struct Spot {
    Eigen::Vector3d point;  // in the world [m]
    bool white;
  };
  struct Marker {
    std::vector<Spot> border, bits;  // the border: black, and white outside of it
    int max_wrong = 0;               // bits that may differ
  };
  double square_ = 0;  // [m]
  std::vector<Marker> markers_;
  std::vector<Spot> spots_;  // as many black as white ones, over the whole sheet
};

}  // namespace livemvs
