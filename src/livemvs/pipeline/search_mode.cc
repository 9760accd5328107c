#include "livemvs/pipeline/search_mode.h"

#include <algorithm>
#include <cmath>

namespace livemvs {

double MedianDisparityRange(const std::vector<CameraPose>& cameras, const SceneRange& range) {
  std::vector<double> lengths;
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    const CameraPose& ref = cameras[i - 1];
    const CameraPose& cur = cameras[i];
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

Search ChooseSearch(const std::vector<CameraPose>& cameras,
                    const SceneRange& range,
                    const Options& options) {
  if (options.search != Search::kAuto) return options.search;
  // The window follows the projection of the mean; it must hold half of the interval at the first step,
  // and does well to about twice that, because steps add up slowly in the frames that follow.
  const double reach = 4 * static_cast<double>(options.search_radius_max_px);
  return MedianDisparityRange(cameras, range) > reach ? Search::kFull : Search::kWindow;
}

}  // namespace livemvs
