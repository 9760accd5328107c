#include "livemvs/pipeline/search_mode.h"

#include <algorithm>
#include <cmath>

namespace livemvs {

double MedianDisparityRange(const std::vector<PosedCamera>& cameras, const SceneRange& range) {
  std::vector<double> lengths;
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    const PosedCamera& ref = cameras[i - 1];
    const PosedCamera& cur = cameras[i];
    const Projector projector(cur.camera);
    const Rigid3d cur_from_ref = cur.cam_from_world * ref.cam_from_world.Inverse();
    const Eigen::Vector3d axis(0, 0, 1);
    const auto near = projector.Project(cur_from_ref * Eigen::Vector3d(axis * range.near));
    const auto far = projector.Project(cur_from_ref * Eigen::Vector3d(axis * range.far));
    if (near && far) lengths.push_back((*near - *far).norm());
  }
  if (lengths.empty()) return 0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

Options ResolveSearch(const std::vector<PosedCamera>& cameras,
                      const SceneRange& range,
                      const Options& options) {
  Options resolved = options;
  if (options.search == Search::kAuto) {
    // The window follows the projection of the mean; it must hold half of the interval at the first
    // step, and does well to about twice that, because a seed is planted in many frames.
    const double reach = 2 * static_cast<double>(options.search_radius_max_px);
    resolved.search =
        MedianDisparityRange(cameras, range) > reach ? Search::kFull : Search::kWindow;
  }
  if (resolved.search == Search::kFull) {
    resolved.prior_a = std::min(options.prior_a, 2.0F);
    resolved.prior_b = std::min(options.prior_b, 2.0F);
    resolved.min_views = std::min(options.min_views, 3);
    resolved.outlier_certainty = std::min(options.outlier_certainty, 0.8F);
    resolved.max_unseen = std::min(options.max_unseen, 3);
  }
  return resolved;
}

}  // namespace livemvs
