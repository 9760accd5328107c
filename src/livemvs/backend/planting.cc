#include "livemvs/backend/planting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "livemvs/core/camera.h"
#include "livemvs/core/texture.h"

namespace livemvs {
namespace {

// Seeds keep this far from the border, so that their patch and its gradient lie in the picture.
constexpr int kBorder = kPatchRadius + 1;

// The part of the picture, less a border, onto which the scene's box projects; all of it where
// there is no box or the camera is too near for its corners to tell.
PixelRect RectOfRange(const Camera& camera,
                      const Rigid3d& cam_from_world,
                      const SceneRange& range) {
  const PixelRect all = {kBorder,
                         kBorder,
                         std::max(kBorder, camera.width - kBorder),
                         std::max(kBorder, camera.height - kBorder)};
  const std::optional<Box> box = range.SoughtBox();
  if (!box) return all;
  const Projector projector(camera);
  Eigen::AlignedBox2d bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p(corner & 1 ? box->max.x() : box->min.x(),
                            corner & 2 ? box->max.y() : box->min.y(),
                            corner & 4 ? box->max.z() : box->min.z());
    const auto pixel = projector.Project(cam_from_world * p);
    if (!pixel) return all;
    bounds.extend(*pixel);
  }
  // A lens bends the box's edges outwards between the corners.
  const double margin = camera.model == CameraModel::kPinhole ? 1 : 0.1 * bounds.diagonal().norm();
  const auto clamped = [&](double v, int low, int high) {
    return static_cast<int>(std::clamp(v, static_cast<double>(low), static_cast<double>(high)));
  };
  return {clamped(std::floor(bounds.min().x() - margin), all.x0, all.x1),
          clamped(std::floor(bounds.min().y() - margin), all.y0, all.y1),
          clamped(std::ceil(bounds.max().x() + margin) + 1, all.x0, all.x1),
          clamped(std::ceil(bounds.max().y() + margin) + 1, all.y0, all.y1)};
}

}  // namespace

Posterior<float> PriorOf(const Options& options) {
  constexpr float kSigmas99 = 2.5758F;  // 99 % of a normal distribution lie within so many
  constexpr float kSigma = 0.5F / kSigmas99;
  return {0.5F, kSigma * kSigma, options.prior_a, options.prior_b};
}

PlantView MakePlantView(const Options& options,
                        const Planting& planting,
                        int level,
                        const ImageView<std::uint8_t>& grey) {
  const Rigid3d& pose = planting.frame.cam_from_world;
  const Eigen::Vector3d center = pose.Center();
  PlantView view;
  view.grey = grey;
  view.camera = MakeCameraParams<double>(AtLevel(planting.frame.camera, level));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) view.rotation[3 * i + j] = pose.rotation(i, j);
    view.center[i] = center[i];
  }
  view.range = BoundsOf(*planting.range);
  view.noise2 = NoiseVariance(options, level);
  // On coarser levels seeds are few, and what is beside an edge has nothing else to tell of it.
  view.max_offset = level == 0 ? options.max_texture_offset_px : 0;
  return view;
}

CandidateRule MakeCandidateRule(const Options& options, const Planting& planting, int level) {
  return {
      RectOfRange(
          AtLevel(planting.frame.camera, level), planting.frame.cam_from_world, *planting.range),
      options.seed_spacing_px,
      options.cover_radius_px,
      level > 0 ? options.min_coarse_stddev : options.min_patch_stddev};
}

Share TakeShare(std::size_t wanted, PhaseCounts* left) {
  const auto any_left = std::find_if(left->begin(), left->end(), [](auto n) { return n > 0; });
  const int first = static_cast<int>(any_left - left->begin());
  Share share{first, first, 0, 1, 0};
  for (auto it = any_left; it != left->end(); ++it) {
    std::size_t& count = *it;
    if (count > wanted - share.size) {
      share.some = wanted - share.size;
      share.all = count;
      share.size += share.some;
      count -= share.some;
      break;
    }
    share.size += count;
    count = 0;
    ++share.whole;
  }
  return share;
}

}  // namespace livemvs
