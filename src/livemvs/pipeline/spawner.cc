#include "livemvs/pipeline/spawner.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

// A point whose pixel was this many times as wide as a pixel here does not cover it.
constexpr float kCoarser = 1.5F;

// Seeds or points that a thread takes at a time.
constexpr std::size_t kGrain = 1024;

// Seeds keep this far from the border, so that their patch and its gradient lie in the picture.
constexpr int kBorder = kPatchRadius + 1;

// Intervals shorter than this fraction of the depth hold nothing worth finding.
constexpr double kShortestInterval = 0.01;

// 99 % of a normal distribution lie within this many standard deviations: the prior's width,
// Sec. 4.2.
constexpr float kSigmas99 = 2.5758F;

// Order in which the pixels of a 4 x 4 cell are taken (Bayer): any number of the first phases is
// even.
constexpr int kPhases = 16;
constexpr std::array<std::uint8_t, kPhases> kPhaseOfCell = {
    0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};

// Moments of a column of kPatchSize pixels.
struct ColumnSums {
  std::vector<std::int32_t> sum, squares;
};

void SumColumns(const ImageView<std::uint8_t>& grey, int y, ColumnSums* columns) {
  std::fill(columns->sum.begin(), columns->sum.end(), 0);
  std::fill(columns->squares.begin(), columns->squares.end(), 0);
  for (int dy = -kPatchRadius; dy <= kPatchRadius; ++dy) {
    const std::uint8_t* row = grey.Row(y + dy);
    for (int x = 0; x < grey.width; ++x) {
      columns->sum[x] += row[x];
      columns->squares[x] += row[x] * row[x];
    }
  }
}

// The part of the picture, less a border, onto which the scene's box projects; all of it where
// there is no box or the camera is too near for its corners to tell.
PixelRect RectOfRange(const Camera& camera,
                      const Rigid3d& cam_from_world,
                      const SceneRange& range) {
  const PixelRect all = {kBorder, kBorder, camera.width - kBorder, camera.height - kBorder};
  if (!range.box) return all;
  const Projector projector(camera);
  Eigen::AlignedBox2d bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p(corner & 1 ? range.box->max.x() : range.box->min.x(),
                            corner & 2 ? range.box->max.y() : range.box->min.y(),
                            corner & 4 ? range.box->max.z() : range.box->min.z());
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
    : options_(options), range_(range) {
  range_.Check();
}

std::int64_t Spawner::Spawn(const PosedFrame& frame,
                            std::span<const ImageView<std::uint8_t>> pyramid,
                            const PointCloud& points,
                            SeedPool* pool) {
  maps_.resize(pyramid.size());
  std::int64_t planted = 0;
  // Coarse seeds first: they are few.
  for (std::size_t l = pyramid.size(); l-- > 0;) {
    const int level = static_cast<int>(l);
    const View view = {
        level, pyramid[l], AtLevel(frame.camera, level), frame.cam_from_world, frame.index};
    Maps& maps = maps_[l];
    if (maps.covered.width() != view.grey.width || maps.covered.height() != view.grey.height) {
      maps.covered = Image<std::uint8_t>(view.grey.width, view.grey.height);
      maps.candidate = Image<std::uint8_t>(view.grey.width, view.grey.height);
    }
    for (int y = 0; y < view.grey.height; ++y) {
      std::memset(maps.covered.Row(y), 0, view.grey.width);
    }
    if (options_.cover_radius_px >= 0) {
      CoverBySeeds(view, *pool, &maps);
      CoverByPoints(view, points, &maps);
    }
    FindCandidates(view, &maps);
    planted += Plant(view, maps, pool->free_slots(), pool);
  }
  return planted;
}

void Spawner::Stamp(float x, float y, Image<std::uint8_t>* covered) const {
  const int radius = options_.cover_radius_px;
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
  const int x0 = std::max(cx - radius, 0), x1 = std::min(cx + radius, covered->width() - 1);
  const int y0 = std::max(cy - radius, 0), y1 = std::min(cy + radius, covered->height() - 1);
  for (int v = y0; v <= y1; ++v) {
    for (int u = x0; u <= x1; ++u) {
      std::atomic_ref<std::uint8_t>((*covered)(u, v)).store(1, std::memory_order_relaxed);
    }
  }
}

void Spawner::CoverBySeeds(const View& view, const SeedPool& pool, Maps* maps) const {
  const SeedColumns& s = pool.columns();
  const CameraParams<float> params = MakeCameraParams<float>(view.camera);
  for (const ReferenceFrame& reference : pool.references()) {
    if (reference.level != view.level) continue;
    const RelativeView<float> relative = MakeRelativeView(
        reference.camera, reference.cam_from_world, view.camera, params, view.cam_from_world);
    VisitModel(view.camera.model, [&](auto model) {
      ParallelForRange(
          reference.begin, reference.end, kGrain, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
              if (s.fate[i] != Fate::kAlive) continue;
              const auto p = ProjectSeed<decltype(model)>(relative,
                                                          options_.coordinate,
                                                          {s.c0[i], s.c1[i]},
                                                          s.bearing_x[i],
                                                          s.bearing_y[i],
                                                          s.mu[i]);
              if (p.visible && p.x >= 0 && p.y >= 0 && p.x < relative.width &&
                  p.y < relative.height) {
                Stamp(p.x, p.y, &maps->covered);
              }
            }
          });
    });
  }
}

void Spawner::CoverByPoints(const View& view, const PointCloud& points, Maps* maps) const {
  const CameraParams<float> camera = MakeCameraParams<float>(view.camera);
  const Eigen::Matrix3f rotation = view.cam_from_world.rotation.cast<float>();
  const Eigen::Vector3f translation = view.cam_from_world.translation.cast<float>();
  const Eigen::Vector3f center = view.cam_from_world.Center().cast<float>();
  const float min_cosine = std::cos(options_.cover_angle_deg * static_cast<float>(M_PI / 180));
  const auto pixel_width = static_cast<float>(1 / view.camera.FocalLength());
  const auto width = static_cast<float>(view.camera.width);
  const auto height = static_cast<float>(view.camera.height);
  VisitModel(view.camera.model, [&](auto model) {
    ParallelForRange(0, points.size(), kGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Eigen::Vector3f p = rotation * points[i].position + translation;
        if (!(p.z() > 0)) continue;
        const float x = p.x() / p.z(), y = p.y() / p.z();
        if (!(x * x + y * y <= camera.r2_max)) continue;
        const auto distorted = decltype(model)::Distort(camera.k, x, y);
        const float u = camera.fx * distorted.x + camera.cx;
        const float v = camera.fy * distorted.y + camera.cy;
        if (!(u >= 0 && v >= 0 && u < width && v < height)) continue;
        // The back of an object does not cover its front: compare the directions of view.
        const Eigen::Vector3f to_camera = (center - points[i].position).normalized();
        if (!(to_camera.dot(points[i].normal) > min_cosine)) continue;
        // A coarse point does not stand for the finer ones that may still be found.
        if (points[i].footprint <= kCoarser * p.norm() * pixel_width) Stamp(u, v, &maps->covered);
      }
    });
  });
}

void Spawner::FindCandidates(const View& view, Maps* maps) const {
  const ImageView<std::uint8_t>& grey = view.grey;
  const PixelRect rect = RectOfRange(view.camera, view.cam_from_world, range_);
  const float stddev = view.level > 0 ? options_.min_coarse_stddev : options_.min_patch_stddev;
  constexpr float kPixels = kPatchPixels;
  // n² var = n Σv² - (Σv)², in integers.
  const auto least = static_cast<std::int32_t>(stddev * stddev * kPixels * kPixels);
  ParallelForRange(kBorder,
                   std::max(kBorder, grey.height - kBorder),
                   32,
                   [&](std::size_t first_row, std::size_t last_row) {
                     ColumnSums columns{std::vector<std::int32_t>(grey.width),
                                        std::vector<std::int32_t>(grey.width)};
                     for (int y = static_cast<int>(first_row); y < static_cast<int>(last_row);
                          ++y) {
                       std::memset(maps->candidate.Row(y), 0, grey.width);
                       if (y < rect.y0 || y >= rect.y1 || y % options_.seed_spacing_px != 0)
                         continue;
                       SumColumns(grey, y, &columns);
                       for (int x = rect.x0; x < rect.x1; ++x) {
                         if (x % options_.seed_spacing_px != 0 || maps->covered(x, y)) continue;
                         std::int32_t sum = 0, squares = 0;
                         for (int dx = -kPatchRadius; dx <= kPatchRadius; ++dx) {
                           sum += columns.sum[x + dx];
                           squares += columns.squares[x + dx];
                         }
                         if (kPatchPixels * squares - sum * sum < least) continue;
                         const int cell_x = x / options_.seed_spacing_px % 4,
                                   cell_y = y / options_.seed_spacing_px % 4;
                         maps->candidate(x, y) =
                             static_cast<std::uint8_t>(1 + kPhaseOfCell[4 * cell_y + cell_x]);
                       }
                     }
                   });
}

std::int64_t Spawner::Plant(const View& view,
                            const Maps& maps,
                            std::size_t slots,
                            SeedPool* pool) const {
  const int width = view.grey.width, height = view.grey.height;
  std::array<std::size_t, kPhases> count{};
  for (int y = kBorder; y < height - kBorder; ++y) {
    for (int x = kBorder; x < width - kBorder; ++x) {
      if (maps.candidate(x, y) > 0) ++count[maps.candidate(x, y) - 1];
    }
  }
  // Whole phases as far as they fit; of the next, an even share.
  int full = 0;
  std::size_t left = slots;
  while (full < kPhases && count[full] <= left) left -= count[full++];
  const std::size_t share_of = full < kPhases ? count[full] : 1;
  std::size_t carry = 0;
  const Projector projector(view.camera);
  pool->BeginReference(view.frame_index, view.level, view.camera, view.cam_from_world);
  std::int64_t planted = 0;
  for (int y = kBorder; y < height - kBorder; ++y) {
    for (int x = kBorder; x < width - kBorder; ++x) {
      const int phase = maps.candidate(x, y) - 1;
      if (phase < 0 || phase > full) continue;
      if (phase == full) {
        carry += left;
        if (carry < share_of) continue;
        carry -= share_of;
      }
      planted += PlantOne(view, projector, x, y, pool);
    }
  }
  pool->EndReference();
  return planted;
}

bool Spawner::PlantOne(
    const View& view, const Projector& projector, int x, int y, SeedPool* pool) const {
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
  constexpr float kSigma = 0.5F / kSigmas99;
  pool->Add(seed, {0.5F, kSigma * kSigma, options_.prior_a, options_.prior_b});
  return true;
}

}  // namespace livemvs
