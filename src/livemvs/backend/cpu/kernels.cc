// Compiled once per instruction set, with LIVEMVS_TARGET naming it. All that is not a template of
// core's lives in the namespace of that set, so that the linker cannot mix the copies.

#include "livemvs/backend/cpu/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace livemvs {
namespace LIVEMVS_TARGET {
namespace {

#include "livemvs/backend/cpu/lanes.inc"
#include "livemvs/backend/cpu/matcher.inc"

/// Seeds that are prepared together, so that those with windows of like length are searched side by
/// side.
constexpr std::size_t kBlock = 512;

/// A search radius that the seed's interval always cuts short [px].
constexpr float kWholeLine = 1e4F;

/// Frames in which a seed may look for its first match on the whole line, which is long.
constexpr int kBirthTries = 2;

/// Width of a posterior that starts from a single match, in standard deviations of that match.
constexpr float kBirthSigmas = 2;

/// A seed in the current frame, from its projection to its match.
struct LineSearch {
  std::size_t seed;  ///< Index into the columns.
  Projection<float> projection;
  SearchRange range;
  float scale;        ///< Of the sampling grid.
  float tau2_px;      ///< Variance of a match [px²].
  float bias2_px;     ///< Variance of the error that all matches of the seed share [px²].
  bool born;          ///< False while the whole interval is searched for a first match.
  bool had_parallax;  ///< The frame lay far enough from the seed's own to tell something.
};

/// A successful measurement.
struct Measurement {
  float x;     ///< mu of the match.
  float tau2;  ///< Its variance [mu²].
  float u;     ///< Density of outliers there.
};

/// Distance from the patch's centre within which samples are taken [px].
float MarginOf(bool warp, float scale) {
  constexpr float kInterpolation =
      1.5F;  // the half-pixel step of the refinement, and the right neighbour
  if (!warp) return kPatchRadius + kInterpolation;
  return kPatchRadius * 1.4143F * scale + kInterpolation;
}

/// The share of the noise in the sum of squared derivatives of Texture(), in units of the noise's
/// variance: half of it in each central difference, of which two degrees of freedom are taken off.
constexpr float kNoiseShare = 0.5F * 7 * kPatchPixels / 9;

/// tau of [VH11] Sec. 3, in pixels, and the error that all matches of a seed share. Beside the
/// matcher's own sigma there is what the image noise adds where the patch has little texture along
/// the line (the Cramér-Rao bound of a shift between two noisy patches), and what an error across
/// the line does where the patch's edges cross it at a slant.
void PredictErrors(const UpdateJob& job, const TextureSums& texture, LineSearch* search) {
  const Options& options = *job.options;
  const float noise = std::ldexp(options.image_noise, -job.group->level);
  const float noise2 = noise * noise;
  const float signal = std::max(texture.along2 - kNoiseShare * noise2, 0.0F) + 1e-6F;
  const float slip = options.epipolar_error_px * texture.along_across / signal;
  const float own = options.measurement_sigma_px * options.measurement_sigma_px;
  search->tau2_px = own + (noise2 > 0 ? 2 * noise2 / signal : 0) + slip * slip;
  search->bias2_px = options.match_bias_px * options.match_bias_px + slip * slip;
}

/// Whether a patch has any contrast at all.
bool IsFlat(const std::uint8_t* patch) {
  return std::all_of(patch, patch + kPatchPixels, [&](std::uint8_t v) { return v == patch[0]; });
}

/// [VH11] Algorithm 1, step 2a: projects the ray and decides where along it to search. kMatched
/// where there is something to search for.
template <typename Model>
MatchStatus Prepare(const UpdateJob& job, std::size_t i, LineSearch* search) {
  const Options& options = *job.options;
  const SeedColumns& s = job.seeds;
  const RelativeView<float>& view = job.group->view;
  search->seed = i;
  search->born = options.search != Search::kFull || s.counts[i].views > 0;
  search->projection = ProjectSeed<Model>(
      view, options.coordinate, {s.c0[i], s.c1[i]}, s.bearing_x[i], s.bearing_y[i], s.mu[i]);
  const Projection<float>& p = search->projection;
  search->had_parallax = false;
  if (!p.visible) return MatchStatus::kOutOfView;
  const float sigma_px = std::sqrt(s.sigma2[i]) * p.rate;
  constexpr float kAtRest = 1e-3F;  // pixels that the whole interval spans: no line to search
  if (!(4 * sigma_px >= options.min_parallax_px && p.rate > kAtRest)) {
    const bool inside = p.x >= 0 && p.y >= 0 && p.x <= view.width - 1 && p.y <= view.height - 1;
    return inside ? MatchStatus::kNoInformation : MatchStatus::kOutOfView;
  }
  search->had_parallax = true;
  search->scale = Clamp(p.scale, 0.25F, 4.0F);
  const float radius = search->born ? Clamp(options.search_sigmas * sigma_px,
                                            options.search_radius_px,
                                            options.search_radius_max_px)
                                    : kWholeLine;
  search->range = ClipSearch(view, p, s.mu[i], radius, MarginOf(job.warp, search->scale));
  if (search->range.last - search->range.first < 2) return MatchStatus::kOutOfView;
  // The line's direction in the reference patch.
  const float c = job.warp ? view.roll_cos : 1, r = job.warp ? view.roll_sin : 0;
  PredictErrors(
      job, Texture(s.patch + i * kPatchPixels, c * p.dx + r * p.dy, c * p.dy - r * p.dx), search);
  if (search->tau2_px > options.max_measurement_sigma_px * options.max_measurement_sigma_px ||
      IsFlat(s.patch + i * kPatchPixels)) {
    return MatchStatus::kNoInformation;
  }
  return MatchStatus::kMatched;
}

/// Turns the best maximum into a measurement of the seed's coordinate.
MatchStatus Conclude(const UpdateJob& job,
                     const LineSearch& search,
                     const LineMatch& match,
                     Measurement* measurement) {
  const Options& options = *job.options;
  if (match.score <= -2 || match.score < options.min_ncc) return MatchStatus::kMismatch;
  if (options.ambiguity_ncc > 0 && match.runner_up > match.score - options.ambiguity_ncc) {
    return MatchStatus::kNoInformation;
  }
  const Projection<float>& p = search.projection;
  measurement->x = job.seeds.mu[search.seed] + MuStep(p, match.offset);
  measurement->tau2 = search.tau2_px / (p.rate * p.rate);
  measurement->u = 1;
  if (options.outlier_density == OutlierDensity::kWindow) {
    const float length = MuStep(p, static_cast<float>(search.range.last) - 0.5F) -
                         MuStep(p, static_cast<float>(search.range.first) + 0.5F);
    measurement->u = 1 / Clamp(length, 1e-6F, 1.0F);
  }
  return MatchStatus::kMatched;
}

/// [VH11] Algorithm 1, step 2c, and the judgement of steps 3 and 4.
void Finish(const UpdateJob& job,
            const LineSearch& search,
            MatchStatus status,
            const Measurement& measurement) {
  const SeedColumns& s = job.seeds;
  const std::size_t i = search.seed;
  SeedCounts counts = s.counts[i];
  Posterior<float> q = {s.mu[i], s.sigma2[i], s.a[i], s.b[i]};
  if (status == MatchStatus::kMatched && !search.born) {
    // Differs from [VH11]: where one frame's step is wider than any window, the best match on the
    // whole line is the hypothesis that the next frames put to the test.
    q = {measurement.x, kBirthSigmas * kBirthSigmas * measurement.tau2, q.a + 1, q.b};
    counts.views = 1;
  } else if (status == MatchStatus::kMatched) {
    const Fused<float> fused = Fuse(q, measurement.x, measurement.tau2, measurement.u);
    q = fused.posterior;
    if (fused.inlier_weight > 0.5F && counts.views < 255) ++counts.views;
  } else if (status == MatchStatus::kMismatch) {
    q = Miss(q);
  }
  // A camera at rest ages nobody; a patch that cannot be matched wherever the camera goes, does.
  if (status == MatchStatus::kMatched || status == MatchStatus::kMismatch ||
      (status == MatchStatus::kNoInformation && (search.had_parallax || !search.born))) {
    ++counts.age;
  }
  counts.unseen = status != MatchStatus::kOutOfView ? 0
                  : counts.unseen < 255             ? static_cast<std::uint8_t>(counts.unseen + 1)
                                                    : counts.unseen;
  const float total_sigma2 =
      status == MatchStatus::kMatched
          ? TotalVariance(q.sigma2, search.bias2_px, 1 / search.projection.rate)
          : -1;
  Fate fate = Judge(*job.options,
                    *job.is_outlier,
                    {s.c0[i], s.c1[i]},
                    q,
                    counts,
                    total_sigma2,
                    job.group->pixel_width);
  if (!search.born && counts.views == 0 && counts.age >= kBirthTries) fate = Fate::kOutlier;
  s.mu[i] = q.mu;
  s.sigma2[i] = fate == Fate::kConverged ? total_sigma2 : q.sigma2;
  s.a[i] = q.a;
  s.b[i] = q.b;
  s.counts[i] = counts;
  s.fate[i] = fate;
}

/// Fills the lanes of a batch from `count` searches; the rest repeat the last.
void FillBatch(const UpdateJob& job,
               const LineSearch* const* searches,
               int count,
               SearchBatch* batch) {
  const RelativeView<float>& view = job.group->view;
  for (int l = 0; l < kLanes; ++l) {
    const LineSearch& search = *searches[std::min(l, count - 1)];
    const Projection<float>& p = search.projection;
    batch->x[l] = p.x;
    batch->y[l] = p.y;
    batch->dx[l] = p.dx;
    batch->dy[l] = p.dy;
    batch->step_x[l] = search.scale * view.roll_cos;
    batch->step_y[l] = search.scale * view.roll_sin;
    batch->first[l] = search.range.first;
    batch->last[l] = search.range.last;
    const std::uint8_t* patch = job.seeds.patch + search.seed * kPatchPixels;
    for (int k = 0; k < kPatchPixels; ++k) batch->patch[k][l] = static_cast<float>(patch[k]);
  }
}

/// Updates seeds [begin, end), kBlock at most, and counts them by status.
template <typename Model>
void UpdateBlock(const UpdateJob& job, std::size_t begin, std::size_t end, std::int64_t* count) {
  LineSearch searches[kBlock];
  const LineSearch* order[kBlock];
  int found = 0;
  const auto finish = [&](const LineSearch& search, MatchStatus status, const Measurement& m) {
    Finish(job, search, status, m);
    ++count[static_cast<int>(status)];
  };
  for (std::size_t i = begin; i < end; ++i) {
    if (job.seeds.fate[i] != Fate::kAlive) continue;
    LineSearch& search = searches[found];
    const MatchStatus status = Prepare<Model>(job, i, &search);
    if (status == MatchStatus::kMatched) {
      order[found] = &search;
      ++found;
    } else {
      finish(search, status, {});
    }
  }
  std::sort(order, order + found, [](const LineSearch* a, const LineSearch* b) {
    const int length_a = a->range.last - a->range.first, length_b = b->range.last - b->range.first;
    return length_a != length_b ? length_a < length_b : a < b;
  });
  SearchBatch batch;
  BatchMatch match;
  for (int first = 0; first < found; first += kLanes) {
    const int used = std::min(kLanes, found - first);
    FillBatch(job, order + first, used, &batch);
    if (job.warp) {
      SearchLines<WarpedSampler>(batch, job.image, &match);
    } else {
      SearchLines<AlignedSampler>(batch, job.image, &match);
    }
    for (int l = 0; l < used; ++l) {
      const LineSearch& search = *order[first + l];
      Measurement measurement{};
      const MatchStatus status = Conclude(
          job, search, {match.score[l], match.runner_up[l], match.offset[l]}, &measurement);
      finish(search, status, measurement);
    }
  }
}

}  // namespace

UpdateStatistics Update(const UpdateJob& job, std::size_t begin, std::size_t end) {
  std::int64_t count[4] = {};
  VisitModel(job.model, [&](auto model) {
    for (std::size_t i = begin; i < end; i += kBlock) {
      UpdateBlock<decltype(model)>(job, i, std::min(i + kBlock, end), count);
    }
  });
  UpdateStatistics statistics;
  statistics.matched = count[static_cast<int>(MatchStatus::kMatched)];
  statistics.no_information = count[static_cast<int>(MatchStatus::kNoInformation)];
  statistics.out_of_view = count[static_cast<int>(MatchStatus::kOutOfView)];
  statistics.mismatched = count[static_cast<int>(MatchStatus::kMismatch)];
  return statistics;
}

}  // namespace LIVEMVS_TARGET
}  // namespace livemvs
