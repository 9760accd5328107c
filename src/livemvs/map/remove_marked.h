#pragma once

#include <cstddef>
#include <vector>

#include "livemvs/core/point.h"

namespace livemvs {

/// Removes the points whose mark, one for each, is not 0; the order of the rest is kept.
/// @return How many were removed.
inline std::size_t RemoveMarked(const std::vector<char>& marks, PointCloud* cloud) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    if (marks[i] == 0) (*cloud)[kept++] = (*cloud)[i];
  }
  const std::size_t removed = cloud->size() - kept;
  cloud->resize(kept);
  return removed;
}

}  // namespace livemvs
