#include "livemvs/pipeline/spawner.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "livemvs/core/texture.h"
#include "livemvs/pipeline/seed_groups.h"

namespace livemvs {
namespace {

// Offers per seed that is still wanted: somewhat fewer than the last round suggests, so that the
// last of them are spread over the whole picture; many more where it planted none.
constexpr double kCautious = 0.8, kBolder = 8, kMostOffers = 1e6;

// Seeds keep this far from the border, so that their patch and its gradient lie in the picture.
constexpr int kBorder = kPatchRadius + 1;

// Intervals shorter than this fraction of the depth hold nothing worth finding.
constexpr double kShortestInterval = 0.01;

// 99 % of a normal distribution lie within this many standard deviations: the prior's width,
// Sec. 4.2.
constexpr float kSigmas99 = 2.5758F;

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

Spawner::Spawner(const Options& options, const SceneRange& range)
    : options_(options), range_(range), coverage_(options.cover_angle_deg) {
  range_.Check();
}

std::int64_t Spawner::Spawn(const PosedFrame& frame,
                            std::span<const ImageView<std::uint8_t>> pyramid,
                            const PointCloud& points,
                            SeedPool* pool) {
  pool->Compact();
  coverage_.Reset(pyramid);
  if (options_.cover_radius_px >= 0) {
    const std::vector<SeedGroup> groups =
        MakeGroups(pool->references(), frame.camera, frame.cam_from_world, pyramid.size());
    pool->backend().MarkPlaces(groups, frame.camera.model, coverage_.marks());
    coverage_.MarkPoints(frame, points);
  }
  std::int64_t planted = 0;
  // Coarse seeds first: they are few.
  for (std::size_t l = pyramid.size(); l-- > 0;) {
    const int level = static_cast<int>(l);
    const View view = {
        level, pyramid[l], AtLevel(frame.camera, level), frame.cam_from_world, frame.index};
    candidates_.Find(view.grey,
                     coverage_.marks()[l].view(),
                     {RectOfRange(view.camera, view.cam_from_world, range_),
                      options_.seed_spacing_px,
                      options_.cover_radius_px,
                      level > 0 ? options_.min_coarse_stddev : options_.min_patch_stddev});
    planted += Plant(view, pool);
  }
  return planted;
}

std::int64_t Spawner::Plant(const View& view, SeedPool* pool) {
  pool->BeginReference(view.frame_index, view.level, view.camera, view.cam_from_world);
  std::int64_t planted = 0;
  // Some of those that are offered are refused: what they leave is offered to others. Where most
  // are refused, as outside of the range, more are offered: each round looks at the whole picture.
  double offers_per_seed = 1;
  while (pool->free_slots() > 0) {
    const std::int64_t before = planted;
    const auto wanted =
        static_cast<std::size_t>(offers_per_seed * static_cast<double>(pool->free_slots()));
    const std::size_t offered = PlantShare(view, wanted, pool, &planted);
    if (offered == 0) break;
    const std::int64_t taken = planted - before;
    const double next = taken > 0
                            ? kCautious * static_cast<double>(offered) / static_cast<double>(taken)
                            : kBolder * offers_per_seed;
    offers_per_seed = std::clamp(next, 1.0, kMostOffers);
  }
  constexpr float kSigma = 0.5F / kSigmas99;
  pool->EndReference({0.5F, kSigma * kSigma, options_.prior_a, options_.prior_b});
  return planted;
}

std::size_t Spawner::PlantShare(const View& view,
                                std::size_t wanted,
                                SeedPool* pool,
                                std::int64_t* planted) {
  // Whole phases as far as they fit; of the next, an even share.
  const auto count = candidates_.count();
  int full = 0;
  std::size_t left = wanted;
  while (full < Candidates::kPhases && count[full] <= left) left -= count[full++];
  const std::size_t share_of = full < Candidates::kPhases ? count[full] : 1;
  std::size_t carry = 0, offered = 0;
  const Projector projector(view.camera);
  candidates_.ForEach([&](int x, int y, int phase) {
    if (phase > full || pool->free_slots() == 0) return;
    if (phase == full) {
      carry += left;
      if (carry < share_of) return;
      carry -= share_of;
    }
    candidates_.Take(x, y, phase);
    ++offered;
    *planted += PlantOne(view, projector, x, y, pool);
  });
  return offered;
}

bool Spawner::PlantOne(
    const View& view, const Projector& projector, int x, int y, SeedPool* pool) const {
  float patch[kPatchPixels];
  for (int k = 0; k < kPatchPixels; ++k) {
    patch[k] = view.grey(x + k % kPatchSize - kPatchRadius, y + k / kPatchSize - kPatchRadius);
  }
  if (!CanMatch(options_, NoiseVariance(options_, view.level), patch)) return false;
  const auto ray = projector.Unproject({x, y});
  if (!ray) return false;
  const double norm = ray->norm();
  const Eigen::Vector3d direction = view.cam_from_world.rotation.transpose() * (*ray / norm);
  const auto depths = range_.Along(view.cam_from_world.Center(), direction, 1 / norm);
  if (!depths || depths->second - depths->first < kShortestInterval * depths->second) return false;
  NewSeed seed;
  if (options_.coordinate == DepthCoordinate::kDepth) {
    seed.interval = {static_cast<float>(depths->first), static_cast<float>(depths->second)};
  } else {
    seed.interval = {static_cast<float>(1 / depths->first), static_cast<float>(1 / depths->second)};
  }
  seed.bearing_x = static_cast<float>(ray->x());
  seed.bearing_y = static_cast<float>(ray->y());
  seed.patch = &view.grey(x, y);
  seed.stride = view.grey.stride;
  pool->Add(seed);
  return true;
}

}  // namespace livemvs
