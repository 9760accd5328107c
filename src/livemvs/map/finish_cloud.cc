#include "livemvs/map/finish_cloud.h"

#include "livemvs/map/regularise.h"
#include "livemvs/map/supersede.h"

namespace livemvs {

FinishedCloud FinishCloud(const Options& options, PointCloud* cloud) {
  FinishedCloud result;
  if (options.levels > 1) result.superseded = RemoveSuperseded(cloud);
  if (options.regularise_px > 0) {
    result.unsupported =
        Regularise({.radius_px = options.regularise_px, .min_support = options.min_support}, cloud);
  }
  return result;
}

}  // namespace livemvs
