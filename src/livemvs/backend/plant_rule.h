#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "livemvs/backend/seed_state.h"
#include "livemvs/core/camera.h"
#include "livemvs/core/image.h"
#include "livemvs/core/options.h"
#include "livemvs/core/platform.h"
#include "livemvs/core/scene_range.h"
#include "livemvs/core/texture.h"

namespace livemvs {

// Step 1 of Algorithm 1 for one pixel, on the host and on devices: whether it is a candidate,
// whether a round offers it, and which seed it becomes.

/// Pixels [x0, x1) x [y0, y1).
struct PixelRect {
  int x0, y0, x1, y1;
};

/// What makes a pixel worth a seed.
struct CandidateRule {
  PixelRect rect;    ///< Keeps from the border what a patch needs.
  int spacing;       ///< Distance of neighbouring candidates [px].
  int cover_radius;  ///< Pixels as near to a mark are none; -1: marks do not count.
  float min_stddev;  ///< Of the grey levels of the patch.
};

/// Candidates come in phases: any number of the first ones is spread evenly over the picture.
inline constexpr int kPhases = 16;

/// Phases repeat every so many rows and columns of candidates.
inline constexpr int kCell = 4;

/// The phase of a candidate, whose place is counted in spacings: its turn in its cell (Bayer).
LIVEMVS_DEVICE constexpr int PhaseOf(int column, int row) {
  const int differ = column ^ row;
  return (differ & 1) << 3 | (row & 1) << 2 | (differ & 2) | (row & 2) >> 1;
}

/// n² times the least variance of a patch's n grey levels.
LIVEMVS_HD inline float LeastContrast(const CandidateRule& rule) {
  constexpr float kPixels = kPatchPixels;
  return rule.min_stddev * rule.min_stddev * kPixels * kPixels;
}

/// Whether n² var = n Σv² - (Σv)² of a patch is too little. Grey levels and their sums are whole
/// numbers that float holds; the difference is rounded by less than 4.
LIVEMVS_HD inline bool IsFlat(float sum, float squares, float least_contrast) {
  constexpr float kPixels = kPatchPixels;
  return kPixels * squares - sum * sum < least_contrast;
}

/// 1 + the phase of a pixel of the rule's rectangle, on its grid, that is a candidate; else 0.
/// @param marks  Of the picture's size: 1 where something is known already.
LIVEMVS_DEVICE inline std::uint8_t CandidateAt(const ImageView<std::uint8_t>& grey,
                                               const ImageView<std::uint8_t>& marks,
                                               const CandidateRule& rule,
                                               int x,
                                               int y) {
  float sum = 0, squares = 0;
  for (int k = 0; k < kPatchPixels; ++k) {
    const float v = grey(x + k % kPatchSize - kPatchRadius, y + k / kPatchSize - kPatchRadius);
    sum += v;
    squares += v * v;
  }
  if (IsFlat(sum, squares, LeastContrast(rule))) return 0;
  for (int v = y - rule.cover_radius; v <= y + rule.cover_radius; ++v) {
    for (int u = x - rule.cover_radius; u <= x + rule.cover_radius; ++u) {
      const bool inside = u >= 0 && v >= 0 && u < marks.width && v < marks.height;
      if (inside && marks(u, v) != 0) return 0;
    }
  }
  return static_cast<std::uint8_t>(1 + PhaseOf(x / rule.spacing, y / rule.spacing));
}

/// The pixels that may be candidates, one after the other, row by row: those of the rule's
/// rectangle whose coordinates are multiples of its spacing.
struct CandidateGrid {
  int spacing;
  int column, row;  ///< The first one, counted in spacings.
  int columns, rows;

  LIVEMVS_DEVICE std::size_t size() const { return static_cast<std::size_t>(columns) * rows; }
  LIVEMVS_DEVICE int X(std::size_t i) const {
    return (column + static_cast<int>(i % columns)) * spacing;
  }
  LIVEMVS_DEVICE int Y(std::size_t i) const {
    return (row + static_cast<int>(i / columns)) * spacing;
  }
};

inline CandidateGrid MakeCandidateGrid(const CandidateRule& rule) {
  const auto first = [&](int v) { return (v + rule.spacing - 1) / rule.spacing; };
  const PixelRect& r = rule.rect;
  return {rule.spacing,
          first(r.x0),
          first(r.y0),
          std::max(first(r.x1) - first(r.x0), 0),
          std::max(first(r.y1) - first(r.y0), 0)};
}

/// What a round offers of the candidates that are left: those of the first phases, and of the next
/// one an even share.
struct Share {
  int first;                ///< Phases before this one were offered before.
  int whole;                ///< Phases before this one are offered whole; of this one ...
  std::uint64_t some, all;  ///< ... `some` of `all` candidates.
  std::size_t size;         ///< Candidates that are offered, in all.

  /// Whether a candidate is offered that is the rank-th of its phase, counted row by row.
  LIVEMVS_HD bool Offers(int phase, std::uint64_t rank) const {
    return phase < whole || (phase == whole && rank * some % all + some >= all);
  }
};

/// A frame at one level of its pyramid, as its pixels become seeds.
struct PlantView {
  ImageView<std::uint8_t> grey;
  CameraParams<double> camera;
  double rotation[9];  ///< cam_from_world, row-major.
  double center[3];    ///< Of the camera, in the world.
  RangeBounds range;
  float noise2;      ///< See NoiseVariance().
  float max_offset;  ///< Of the texture's centroid, see IsCentred() [px].
};

/// Makes the seed of a pixel; false where its patch cannot be matched, or its texture lies at its
/// side, or its ray does not cross the scene's range.
template <typename Model>
LIVEMVS_DEVICE bool SeedAt(
    const Options& options, const PlantView& view, int x, int y, NewSeed* seed) {
  // Intervals shorter than this fraction of the depth hold nothing worth finding.
  constexpr double kShortestInterval = 0.01;
  const std::uint8_t* center = &view.grey(x, y);
  if (!CanMatch(options, view.noise2, center, view.grey.stride)) return false;
  if (!IsCentred(view.max_offset, view.noise2, center, view.grey.stride)) return false;
  double ray_x = 0, ray_y = 0;
  if (!UnprojectPixel<Model>(view.camera, x, y, &ray_x, &ray_y)) return false;
  const double norm = std::sqrt(ray_x * ray_x + ray_y * ray_y + 1);
  const double bearing[3] = {ray_x / norm, ray_y / norm, 1 / norm};
  double direction[3];
  for (int i = 0; i < 3; ++i) {
    const double* r = view.rotation + i;
    direction[i] = r[0] * bearing[0] + r[3] * bearing[1] + r[6] * bearing[2];
  }
  double nearest = 0, farthest = 0;
  if (!ClipRay(view.range, view.center, direction, bearing[2], &nearest, &farthest)) return false;
  if (farthest - nearest < kShortestInterval * farthest) return false;
  const bool depth = options.coordinate == DepthCoordinate::kDepth;
  seed->interval = {static_cast<float>(depth ? nearest : 1 / nearest),
                    static_cast<float>(depth ? farthest : 1 / farthest)};
  seed->bearing_x = static_cast<float>(ray_x);
  seed->bearing_y = static_cast<float>(ray_y);
  seed->patch = center;
  seed->stride = view.grey.stride;
  return true;
}

}  // namespace livemvs
