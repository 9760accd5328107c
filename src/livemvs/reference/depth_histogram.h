#pragma once

#include <optional>
#include <vector>

namespace livemvs::reference {

/// Depth by histogram voting, what [VH11] Table 1 is compared with (its refs. [13], [27]): every
/// local maximum of every NCC curve counts one vote in a bin of fixed width, and the fullest bin
/// wins. Has no measure of confidence, and its answers are quantised.
class DepthHistogram {
 public:
  /// @throws std::invalid_argument where z_min < z_max does not hold or there is no bin.
  DepthHistogram(double z_min, double z_max, int bins);

  /// Adds a vote; depths outside of [z_min, z_max] have none.
  void Vote(double depth);

  int bins() const { return static_cast<int>(votes_.size()); }
  int votes(int bin) const { return votes_[bin]; }
  /// Depth of the middle of a bin [scene].
  double Center(int bin) const { return z_min_ + (bin + 0.5) * width_; }

  /// Centre of the fullest bin, the first among equals; nothing before the first vote.
  std::optional<double> Mode() const;

 private:
  double z_min_;
  double width_;
  std::vector<int> votes_;
};

}  // namespace livemvs::reference
