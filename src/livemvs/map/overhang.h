#pragma once

#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

struct OverhangOptions {
  /// How far others are sought [px of the finest level].
  float reach_px = 64;

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// Marks, with 1, the points that overhang: those whose patches have their texture at one side
/// (Point::lean) and that find no agreement at the other. Such a point says at which depth the
/// texture is; that its own pixel is at that depth, too, may be wrong: beside a nearer thing in
/// front of something plain it is not, and the thing looks fatter than it is. Between two points
/// of one surface a third may be believed, beyond the last of them none.
///
/// Three others must agree, with texture all around them: ahead, away from the point's texture as
/// the camera saw it, up to reach_px and 0.6 times that far to the sides; and along the line of
/// sight no further off than twice the distance across it, or what the uncertainties of both allow.
/// Those looked at are the sixteen nearest to each of five places ahead, whose distances double.
/// Points of which it is not known where their texture is neither go nor agree.
///
/// Differs from [VH11], which takes every seed for itself. Multi-threaded; the result does not
/// depend on the number of threads.
/// @return A mark for each point.
[[nodiscard]] std::vector<char> FindOverhanging(const OverhangOptions& options,
                                                const PointCloud& cloud);

}  // namespace livemvs
