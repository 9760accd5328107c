// Compiled once per instruction set, with LIVEMVS_TARGET naming it. All that is not a template of
// core's lives in the namespace of that set, so that the linker cannot mix the copies.

#include "livemvs/backend/cpu/kernels.h"

#include <cmath>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace livemvs {
namespace LIVEMVS_TARGET {
namespace {

#include "livemvs/backend/cpu/matcher.inc"

/// One seed as the kernel works on it.
struct Seed {
  Interval<float> interval;
  Posterior<float> posterior;
  const std::uint8_t* patch;
  bool born;  ///< False while the whole interval is still to be searched for a first match.
};

/// A successful measurement.
struct Measurement {
  float x;     ///< mu of the match.
  float tau2;  ///< Its variance [mu²].
  float u;     ///< Density of outliers there.
  float bias2_px;  ///< Variance of the error that all matches of the seed share [px²].
};

/// A search radius that the seed's interval always cuts short [px].
constexpr float kWholeLine = 1e4F;

/// Frames in which a seed may look for its first match on the whole line, which is long.
constexpr int kBirthTries = 2;

/// Width of a posterior that starts from a single match, in standard deviations of that match.
constexpr float kBirthSigmas = 2;

/// Distance from the patch's centre within which samples are taken [px].
float MarginOf(bool warp, float scale) {
  constexpr float kInterpolation =
      1.5F;  // the half-pixel step of the refinement, and the right neighbour
  if (!warp) return kPatchRadius + kInterpolation;
  return kPatchRadius * 1.4143F * scale + kInterpolation;
}

/// tau of [VH11] Sec. 3, in pixels: the matcher's own, and what the image noise adds where the
/// patch has little gradient along the line (the Cramér-Rao bound of a shift between two noisy
/// patches).
float MeasurementSigma2(const Options& options, float gradient) {
  const float noise2 = options.image_noise * options.image_noise;
  return options.measurement_sigma_px * options.measurement_sigma_px +
         (noise2 > 0 ? 2 * noise2 / (gradient + 1e-6F) : 0);
}

MatchStatus Measure(const UpdateJob& job,
                    const Seed& seed,
                    const Projection<float>& p,
                    Measurement* measurement) {
  const Options& options = *job.options;
  const float sigma_px = std::sqrt(seed.posterior.sigma2) * p.rate;
  constexpr float kAtRest = 1e-3F;  // pixels that the whole interval spans: no line to search
  if (!(4 * sigma_px >= options.min_parallax_px && p.rate > kAtRest)) {
    return MatchStatus::kNoInformation;
  }
  const RelativeView<float>& view = job.group->view;
  // The line's direction in the reference patch.
  const float c = job.warp ? view.roll_cos : 1, s = job.warp ? view.roll_sin : 0;
  const Texture texture = TextureAlong(seed.patch, c * p.dx + s * p.dy, c * p.dy - s * p.dx);
  const float slip = options.epipolar_error_px * texture.along_across / (texture.along2 + 1e-6F);
  const float tau2_px = MeasurementSigma2(options, texture.along2) + slip * slip;
  measurement->bias2_px = options.match_bias_px * options.match_bias_px + slip * slip;
  if (tau2_px > options.max_measurement_sigma_px * options.max_measurement_sigma_px) {
    return MatchStatus::kNoInformation;
  }
  const float scale = Clamp(p.scale, 0.25F, 4.0F);
  const float radius = seed.born ? Clamp(options.search_sigmas * sigma_px,
                                         options.search_radius_px,
                                         options.search_radius_max_px)
                                 : kWholeLine;
  const SearchRange range =
      ClipSearch(view, p, seed.posterior.mu, radius, MarginOf(job.warp, scale));
  if (range.last - range.first < 2) return MatchStatus::kOutOfView;

  const Template t = MakeTemplate(seed.patch);
  if (!(t.sum_of_squares >= 1)) return MatchStatus::kNoInformation;
  const LineMatch match =
      job.warp ? SearchLine(WarpedSampler{job.image, scale * c, scale * s}, t, p, range)
               : SearchLine(AlignedSampler{job.image}, t, p, range);
  if (match.score <= -2 || match.score < options.min_ncc) return MatchStatus::kMismatch;
  if (options.ambiguity_ncc > 0 && match.runner_up > match.score - options.ambiguity_ncc) {
    return MatchStatus::kNoInformation;
  }
  measurement->x = seed.posterior.mu + MuStep(p, match.offset);
  measurement->tau2 = tau2_px / (p.rate * p.rate);
  measurement->u = 1;
  if (options.outlier_density == OutlierDensity::kWindow) {
    const float length = MuStep(p, static_cast<float>(range.last) - 0.5F) -
                         MuStep(p, static_cast<float>(range.first) + 0.5F);
    measurement->u = 1 / Clamp(length, 1e-6F, 1.0F);
  }
  return MatchStatus::kMatched;
}

template <typename Model>
MatchStatus UpdateSeed(const UpdateJob& job, std::size_t i) {
  const SeedColumns& s = job.seeds;
  SeedCounts counts = s.counts[i];
  const Seed seed = {{s.c0[i], s.c1[i]},
                     {s.mu[i], s.sigma2[i], s.a[i], s.b[i]},
                     s.patch + i * kPatchPixels,
                     job.options->search != Search::kFull || counts.views > 0};
  // [VH11] Algorithm 1, step 2a.
  const Projection<float> p = ProjectSeed<Model>(job.group->view,
                                                 job.options->coordinate,
                                                 seed.interval,
                                                 s.bearing_x[i],
                                                 s.bearing_y[i],
                                                 seed.posterior.mu);
  Measurement measurement{};
  const MatchStatus status =
      p.visible ? Measure(job, seed, p, &measurement) : MatchStatus::kOutOfView;  // step 2b
  Posterior<float> q = seed.posterior;
  if (status == MatchStatus::kMatched && !seed.born) {
    // Differs from [VH11]: where one frame's step is wider than any window, the best match on the
    // whole line is the hypothesis that the next frames put to the test.
    q = {measurement.x, kBirthSigmas * kBirthSigmas * measurement.tau2, q.a + 1, q.b};
    counts.views = 1;
  } else if (status == MatchStatus::kMatched) {  // step 2c
    const Fused<float> fused = Fuse(q, measurement.x, measurement.tau2, measurement.u);
    q = fused.posterior;
    if (fused.inlier_weight > 0.5F && counts.views < 255) ++counts.views;
  } else if (status == MatchStatus::kMismatch) {
    q = Miss(q);
  }
  const bool told = status == MatchStatus::kMatched || status == MatchStatus::kMismatch;
  if (told || (!seed.born && status == MatchStatus::kNoInformation)) ++counts.age;
  counts.unseen = status != MatchStatus::kOutOfView ? 0
                  : counts.unseen < 255             ? static_cast<std::uint8_t>(counts.unseen + 1)
                                                    : counts.unseen;
  const float total_sigma2 =
      status == MatchStatus::kMatched ? TotalVariance(q.sigma2, measurement.bias2_px, 1 / p.rate) : -1;
  Fate fate = Judge(*job.options,
                    *job.is_outlier,
                    seed.interval,
                    q,
                    counts,
                    total_sigma2,
                    job.group->pixel_width);
  if (!seed.born && counts.views == 0 && counts.age >= kBirthTries) fate = Fate::kOutlier;
  s.mu[i] = q.mu;
  s.sigma2[i] = fate == Fate::kConverged ? total_sigma2 : q.sigma2;
  s.a[i] = q.a;
  s.b[i] = q.b;
  s.counts[i] = counts;
  s.fate[i] = fate;
  return status;
}

}  // namespace

UpdateStatistics Update(const UpdateJob& job, std::size_t begin, std::size_t end) {
  std::int64_t count[4] = {};
  VisitModel(job.model, [&](auto model) {
    for (std::size_t i = begin; i < end; ++i) {
      if (job.seeds.fate[i] != Fate::kAlive) continue;
      ++count[static_cast<int>(UpdateSeed<decltype(model)>(job, i))];
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
