#include "livemvs/map/finish_cloud.h"

#include "livemvs/map/regularise.h"
#include "livemvs/map/supersede.h"

namespace livemvs {

FinishedCloud FinishCloud(const Options& options,
                          const std::optional<Box>& box,
                          PointCloud* cloud) {
  FinishedCloud result;
  if (options.levels > 1) result.superseded = RemoveSuperseded(box, cloud);
  if (options.regularise_px > 0) {
    result.unsupported =
        Regularise({.radius_px = options.regularise_px, .min_support = options.min_support}, cloud);
  }
  if (box) {
    result.outside = std::erase_if(
        *cloud, [&](const Point& p) { return !box->Contains(p.position.cast<double>()); });
  }
  return result;
}

}  // namespace livemvs
