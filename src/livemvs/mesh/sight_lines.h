#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "livemvs/core/point.h"
#include "livemvs/mesh/mesh_camera.h"
#include "livemvs/mesh/mesh_options.h"

namespace livemvs {

/// A point as a sensor of depth: what lies before it on its line of sight is empty, what lies just
/// behind it is solid.
struct SightLine {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< [scene]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    ///< Unit, towards the camera; zero: unknown.
  Eigen::Vector3f direction =
      Eigen::Vector3f::Zero();  ///< Unit, from the point to its camera; zero: unknown.
  float length = 0;  ///< Of the line from the point on that is known to be empty. [scene]
  float sigma = 0;   ///< Of the depth [scene]; 0: unknown.
  float weight = 1;  ///< Inlier ratio, in (0, 1].
};

struct SightLines {
  std::vector<SightLine> lines;
  std::vector<Rgb> colors;     ///< One for each line.
  double spacing = 0;          ///< Median distance of a point to its neighbours. [scene]
  std::size_t seen = 0;        ///< Lines that end at a known camera; the others have a normal only.
  std::size_t not_finite = 0;  ///< Points that were left out, because they are no numbers, ...
  std::size_t repeated = 0;    ///< ... stand where another does, ...
  std::size_t lonely = 0;      ///< ... or are far from all others.
};

/// Lines of sight of the points of a cloud, fit to be cut: without points that are not finite,
/// repeated, or lonely (the 8th neighbour 20 times farther than is usual).
/// @param cameras  Where the frames of the points were; those of other points see along the normal.
/// @throws Error (kBadInput) where fewer than 10 points are left, they stand in one line or place,
/// or none has a camera or normal.
SightLines MakeSightLines(const PointCloud& cloud, const MeshCameras& cameras);

}  // namespace livemvs
