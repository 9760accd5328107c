#include "livemvs/map/finish_cloud.h"

#include <numeric>

#include "livemvs/map/overhang.h"
#include "livemvs/map/regularise.h"
#include "livemvs/map/remove_marked.h"
#include "livemvs/map/rim.h"
#include "livemvs/map/supersede.h"

namespace livemvs {
namespace {

std::vector<char> FindOutside(const Box& box, const PointCloud& cloud) {
  std::vector<char> outside;
  for (const Point& p : cloud) outside.push_back(!box.Contains(p.position.cast<double>()));
  return outside;
}

}  // namespace

FinishedCloud FinishCloud(const Options& options,
                          const std::optional<Box>& box,
                          PointCloud* cloud) {
  FinishedCloud result;
  result.kept.resize(cloud->size());
  std::iota(result.kept.begin(), result.kept.end(), 0U);
  const auto remove = [&](const std::vector<char>& marks) {
    RemoveMarked(marks, &result.kept);
    return RemoveMarked(marks, cloud);
  };
  if (options.overhang_px > 0) {
    result.overhanging = remove(FindOverhanging({.reach_px = options.overhang_px}, *cloud));
  }
  if (options.levels > 1) result.superseded = remove(FindSuperseded(box, *cloud));
  if (options.regularise_px > 0) {
    result.unsupported = remove(Regularise(
        {.radius_px = options.regularise_px, .min_support = options.min_support}, cloud));
  }
  if (options.rim_px > 0) result.rims = remove(FindRims({.radius_px = options.rim_px}, *cloud));
  if (box) result.outside = remove(FindOutside(*box, *cloud));
  return result;
}

}  // namespace livemvs
