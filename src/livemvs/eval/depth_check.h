#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/point.h"
#include "livemvs/core/pose.h"

namespace livemvs {

/// A camera that measured depth, and where its picture lies.
struct DepthView {
  std::string name;  ///< File name, relative to the folder.
  Camera camera;
  Rigid3d cam_from_world;
};

struct DepthCheckOptions {
  double z_min = 0.3;       ///< Points nearer to the camera are not judged. [scene]
  double z_max = 3.0;       ///< Points farther away are not judged. [scene]
  double tolerance = 0.1;   ///< A point this much in front of the seen surface floats. [scene]
  double unit = 1e-3;       ///< Length of one step of the depth pictures. [scene]
  double depth_max = 60.0;  ///< Measurements beyond it mean "none". [scene]

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

struct DepthCheckResult {
  std::int64_t points = 0;    ///< In the cloud, finite ones.
  std::int64_t frames = 0;    ///< Depth pictures compared.
  std::int64_t agree = 0;     ///< Comparisons within the tolerance.
  std::int64_t floating = 0;  ///< Comparisons in front of the surface by more.
  std::int64_t behind = 0;    ///< Comparisons behind it: hidden or wrong, not judged.
  std::vector<float> errors;  ///< |z error| of those that agree. [scene]

  /// Median of `errors`; 0 where there are none.
  double MedianError() const;

  /// floating / (agree + floating); 0 where there are none.
  double FloatingShare() const;
};

/// Compares a cloud with a depth picture and adds to the result. A point is compared with that of
/// the 3 x 3 measurements about its pixel which is nearest to its own depth, because colour and
/// depth are registered to about a pixel. Points without a measurement there are not judged.
/// @param depth  (camera.height, camera.width); 0 and what is beyond options.depth_max: none.
/// @throws std::invalid_argument where the picture's size is not the camera's.
void CompareWithDepth(const PointCloud& cloud,
                      const DepthView& view,
                      const Image<std::uint16_t>& depth,
                      const DepthCheckOptions& options,
                      DepthCheckResult* result);

/// Reads cams_depth.txt: per line a picture's name, w h fx fy cx cy k1 k2 p1 p2 R(9) t(3),
/// camera-from-world, integer pixel centres; '#' starts a comment.
/// @throws Error (kBadInput) naming file, line and what is wrong.
std::vector<DepthView> ReadDepthViews(const std::filesystem::path& file);

}  // namespace livemvs
