#include "livemvs/reference/depth_histogram.h"

#include <algorithm>
#include <stdexcept>

namespace livemvs::reference {

DepthHistogram::DepthHistogram(double z_min, double z_max, int bins)
    : z_min_(z_min), width_((z_max - z_min) / bins) {
  if (!(z_min < z_max) || bins < 1) {
    throw std::invalid_argument("a depth histogram needs z_min < z_max and at least one bin");
  }
  votes_.assign(bins, 0);
}

void DepthHistogram::Vote(double depth) {
  const double place = (depth - z_min_) / width_;
  if (!(place >= 0 && place <= bins())) return;
  ++votes_[std::min(static_cast<int>(place), bins() - 1)];
}

std::optional<double> DepthHistogram::Mode() const {
  const auto fullest = std::max_element(votes_.begin(), votes_.end());
  if (*fullest == 0) return std::nullopt;
  return Center(static_cast<int>(fullest - votes_.begin()));
}

}  // namespace livemvs::reference
