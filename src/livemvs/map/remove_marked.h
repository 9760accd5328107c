#pragma once

#include <cstddef>
#include <vector>

namespace livemvs {

/// Removes the entries whose mark, one for each, is not 0; the order of the rest is kept.
/// @return How many were removed.
template <typename T>
std::size_t RemoveMarked(const std::vector<char>& marks, std::vector<T>* entries) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < entries->size(); ++i) {
    if (marks[i] == 0) (*entries)[kept++] = (*entries)[i];
  }
  const std::size_t removed = entries->size() - kept;
  entries->resize(kept);
  return removed;
}

}  // namespace livemvs
