#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "livemvs/core/point.h"
#include "livemvs/map/point_index.h"

namespace livemvs {

/// Some points of a cloud, to be searched.
struct PickedPoints {
  std::vector<std::size_t> rows;  ///< Of each of the index, its place in the cloud; ascending.
  PointIndex index;
};

/// The points for which `wanted(point)` holds; their positions must be finite.
template <typename Predicate>
PickedPoints PickPoints(const PointCloud& cloud, const Predicate& wanted) {
  std::vector<std::size_t> rows;
  std::vector<Eigen::Vector3f> positions;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!wanted(cloud[i])) continue;
    rows.push_back(i);
    positions.push_back(cloud[i].position);
  }
  return {std::move(rows), PointIndex(std::move(positions))};
}

}  // namespace livemvs
