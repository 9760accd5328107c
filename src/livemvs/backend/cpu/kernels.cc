// Compiled once per instruction set, with LIVEMVS_TARGET naming it. All that is not a template of
// core's lives in the namespace of that set, so that the linker cannot mix the copies.

#include "livemvs/backend/cpu/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>

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
constexpr int kBlock = 512;
static_assert(kBlock % kLanes == 0);

/// A search radius that the seed's interval always cuts short [px].
constexpr float kWholeLine = 1e4F;

/// Frames in which a seed may look for its first match on the whole line, which is long.
constexpr float kBirthTries = 2;

/// Width of a posterior that starts from a single match, in standard deviations of that match.
constexpr float kBirthSigmas = 2;

constexpr float Number(MatchStatus status) { return static_cast<float>(status); }
constexpr float Number(Fate fate) { return static_cast<float>(fate); }

/// What the seeds of a block do in the current frame, from their projection to their match: an
/// entry per seed.
struct BlockSearch {
  template <typename T>
  using Column = T[kBlock];

  alignas(64) Column<float> x, y, dx, dy, rate, foreshortening;  ///< See Projection.
  alignas(64) Column<float> first, last;                         ///< See SearchRange.
  alignas(64) Column<float> scale;                               ///< Of the sampling grid.
  alignas(64) Column<float> tau2_px;                             ///< Variance of a match [px²].
  /// Variance of the error that all matches of the seed share [px²].
  alignas(64) Column<float> bias2_px;
  alignas(64) Column<float> status;    ///< A MatchStatus; kMatched while there is hope.
  alignas(64) Column<float> parallax;  ///< 1: far enough from the seed's frame to tell something.
  alignas(64) Column<float> score, runner_up, offset;  ///< See LineMatch.
};

/// As many seeds as there are lanes, with their state. Lanes beyond `count` hold zeros.
struct SeedLanes {
  int count;
  Interval<Lanes> interval;
  Lanes bearing_x, bearing_y;
  Posterior<Lanes> q;
  CountsOf<Lanes> counts;
  Mask alive;

  SeedLanes(const SeedColumns& s, std::size_t begin, std::size_t end)
      : count(static_cast<int>(std::min<std::size_t>(end - begin, kLanes))),
        interval{Load(s.c0 + begin, count), Load(s.c1 + begin, count)},
        bearing_x(Load(s.bearing_x + begin, count)),
        bearing_y(Load(s.bearing_y + begin, count)),
        q{Load(s.mu + begin, count),
          Load(s.sigma2 + begin, count),
          Load(s.a + begin, count),
          Load(s.b + begin, count)} {
    static_assert(sizeof(SeedCounts) == 4 && offsetof(SeedCounts, age) == 0 &&
                  offsetof(SeedCounts, views) == 2 && offsetof(SeedCounts, unseen) == 3);
    const Int word = LoadInt(s.counts + begin, count);
    counts = {ToLanes(word & 0xFFFF), Byte<2>(word), Byte<3>(word)};
    const Int fate = LoadBytes(s.fate + begin, count);
    Int lane;
    for (int l = 0; l < kLanes; ++l) lane[l] = l;
    alive = {(fate == static_cast<int>(Fate::kAlive)) & (lane < count)};
  }
};

/// Distance from the patch's centre within which samples are taken [px].
Lanes MarginOf(bool warp, const Lanes& scale) {
  constexpr float kInterpolation =
      1.5F;  // the half-pixel step of the refinement, and the right neighbour
  if (!warp) return kPatchRadius + kInterpolation;
  return kPatchRadius * 1.4143F * scale + kInterpolation;
}

/// The share of the noise in the sum of squared derivatives of Texture(), in units of the noise's
/// variance: half of it in each central difference, of which two degrees of freedom are taken off.
constexpr float kNoiseShare = 0.5F * 7 * kPatchPixels / 9;

/// tau of [VH11] Sec. 3, in pixels, and the error that all matches of a seed share.
struct PredictedErrors {
  Lanes tau2_px, bias2_px;
};

/// Beside the matcher's own sigma there is what the image noise adds where the patch has little
/// texture along the line (the Cramér-Rao bound of a shift between two noisy patches), and what an
/// error across the line does where the patch's edges cross it at a slant.
PredictedErrors PredictErrors(const UpdateJob& job, const TextureSums& texture) {
  const Options& options = *job.options;
  const float noise = std::ldexp(options.image_noise, -job.group->level);
  const float noise2 = noise * noise;
  const Lanes signal = Max(texture.along2 - kNoiseShare * noise2, 0.0F) + 1e-6F;
  const Lanes slip = options.epipolar_error_px * texture.along_across / signal;
  const float own = options.measurement_sigma_px * options.measurement_sigma_px;
  return {own + 2 * noise2 / signal + slip * slip,
          options.match_bias_px * options.match_bias_px + slip * slip};
}

/// [VH11] Algorithm 1, step 2a: projects the rays and decides where along them to search. Writes
/// entries [to, to + kLanes) of the block.
template <typename Model>
void Prepare(const UpdateJob& job, std::size_t begin, std::size_t end, int to, BlockSearch* out) {
  const Options& options = *job.options;
  const RelativeView<float>& view = job.group->view;
  const SeedLanes s(job.seeds, begin, end);
  const Mask born = Everywhere(options.search != Search::kFull) | (s.counts.views > 0.0F);
  const auto p =
      ProjectSeed<Model>(view, options.coordinate, s.interval, s.bearing_x, s.bearing_y, s.q.mu);
  const Lanes sigma_px = Sqrt(s.q.sigma2) * p.rate;
  constexpr float kAtRest = 1e-3F;  // pixels that the whole interval spans: no line to search
  const Mask moves = (4.0F * sigma_px >= options.min_parallax_px) & (p.rate > kAtRest);
  const Mask inside =
      (p.x >= 0.0F) & (p.y >= 0.0F) & (p.x <= view.width - 1) & (p.y <= view.height - 1);
  const Lanes scale = Clamp(p.scale, Lanes(0.25F), Lanes(4.0F));
  const Lanes radius = Select(born,
                              Clamp(options.search_sigmas * sigma_px,
                                    Lanes(options.search_radius_px),
                                    Lanes(options.search_radius_max_px)),
                              kWholeLine);
  const SearchRange<Lanes> range = ClipSearch(view, p, s.q.mu, radius, MarginOf(job.warp, scale));
  const Mask room = range.last - range.first >= 2.0F;
  PredictedErrors errors = {0, 0};
  Mask matchable = s.alive & p.visible & moves & room;
  if (Any(matchable)) {
    Int offset;
    for (int l = 0; l < kLanes; ++l) offset[l] = std::min(l, s.count - 1) * kPatchPixels;
    const Patches patches = LoadPatches(job.seeds.patch + begin * kPatchPixels, offset);
    // The line's direction in the reference patch.
    const float c = job.warp ? view.roll_cos : 1, r = job.warp ? view.roll_sin : 0;
    errors = PredictErrors(job, Texture(patches, c * p.dx + r * p.dy, c * p.dy - r * p.dx));
    const float most = options.max_measurement_sigma_px * options.max_measurement_sigma_px;
    matchable = matchable & (errors.tau2_px <= most) & ~IsFlat(patches);
  }
  Lanes status = Select(room, Number(MatchStatus::kNoInformation), Number(MatchStatus::kOutOfView));
  status =
      Select(moves,
             status,
             Select(inside, Number(MatchStatus::kNoInformation), Number(MatchStatus::kOutOfView)));
  status = Select(p.visible, status, Number(MatchStatus::kOutOfView));
  status = Select(matchable, Number(MatchStatus::kMatched), status);
  Store(p.x, out->x + to);
  Store(p.y, out->y + to);
  Store(p.dx, out->dx + to);
  Store(p.dy, out->dy + to);
  Store(p.rate, out->rate + to);
  Store(p.foreshortening, out->foreshortening + to);
  Store(range.first, out->first + to);
  Store(range.last, out->last + to);
  Store(scale, out->scale + to);
  Store(errors.tau2_px, out->tau2_px + to);
  Store(errors.bias2_px, out->bias2_px + to);
  Store(status, out->status + to);
  Store(Select(p.visible & moves, 1.0F, 0.0F), out->parallax + to);
}

/// The entries of a block that have something to search for, those with the shortest ranges first.
class SearchOrder {
 public:
  SearchOrder(const BlockSearch& block, int count) {
    int start[kBuckets + 1] = {};
    for (int i = 0; i < count; ++i) {
      if (IsSearched(block, i)) ++start[Bucket(block, i) + 1];
    }
    for (int b = 0; b < kBuckets; ++b) start[b + 1] += start[b];
    size_ = start[kBuckets];
    const int long_ones = start[kBuckets - 1];
    for (int i = 0; i < count; ++i) {
      if (IsSearched(block, i)) entry_[start[Bucket(block, i)]++] = i;
    }
    std::stable_sort(entry_ + long_ones, entry_ + size_, [&](int a, int b) {
      return block.last[a] - block.first[a] < block.last[b] - block.first[b];
    });
  }

  int size() const { return size_; }

  /// kLanes entries from `first` on; beyond the last, it is repeated.
  Int At(int first) const {
    Int entry;
    if (first + kLanes <= size_) return LoadInt(entry_ + first);
    for (int l = 0; l < kLanes; ++l) entry[l] = entry_[std::min(first + l, size_ - 1)];
    return entry;
  }

 private:
  // Ranges as long or longer, which only whole lines are, share the last bucket.
  static constexpr int kBuckets = 64;

  static bool IsSearched(const BlockSearch& block, int i) {
    return block.status[i] == Number(MatchStatus::kMatched);
  }
  static int Bucket(const BlockSearch& block, int i) {
    return std::min(static_cast<int>(block.last[i] - block.first[i]), kBuckets - 1);
  }

  int size_;
  std::int32_t entry_[kBlock];
};

/// Searches for the patches of some entries of a block, whose first seed is `begin`.
template <typename Sampler>
void SearchEntries(const UpdateJob& job, std::size_t begin, const Int& entry, BlockSearch* block) {
  const RelativeView<float>& view = job.group->view;
  const Lanes scale = Gather(block->scale, entry);
  const SearchBatch batch = {Gather(block->x, entry),
                             Gather(block->y, entry),
                             Gather(block->dx, entry),
                             Gather(block->dy, entry),
                             Gather(block->first, entry),
                             Gather(block->last, entry),
                             scale * view.roll_cos,
                             scale * view.roll_sin};
  const Template t =
      MakeTemplate(LoadPatches(job.seeds.patch + begin * kPatchPixels, entry * kPatchPixels));
  const LineMatch match = SearchLines<Sampler>(batch, t, job.image);
  for (int l = 0; l < kLanes; ++l) {
    block->score[entry[l]] = match.score.v[l];
    block->runner_up[entry[l]] = match.runner_up.v[l];
    block->offset[entry[l]] = match.offset.v[l];
  }
}

/// Measurements of the seeds' coordinates.
struct Measurement {
  Lanes x;     ///< mu of the match.
  Lanes tau2;  ///< Its variance [mu²].
  Lanes u;     ///< Density of outliers there.
};

/// Turns the best maxima into measurements. `status` is kMatched where one may be, and is
/// corrected.
Measurement Conclude(
    const UpdateJob& job, const BlockSearch& block, int at, const Lanes& mu, Lanes* status) {
  const Options& options = *job.options;
  const Lanes score = Load(block.score + at);
  const Mask searched = *status == Number(MatchStatus::kMatched);
  if (options.ambiguity_ncc > 0) {
    const Mask ambiguous = Load(block.runner_up + at) > score - options.ambiguity_ncc;
    *status = Select(searched & ambiguous, Number(MatchStatus::kNoInformation), *status);
  }
  const Mask good = (score > -2.0F) & (score >= options.min_ncc);
  *status = Select(searched & ~good, Number(MatchStatus::kMismatch), *status);
  Projection<Lanes> p;
  p.rate = Load(block.rate + at);
  p.foreshortening = Load(block.foreshortening + at);
  Measurement m = {
      mu + MuStep(p, Load(block.offset + at)), Load(block.tau2_px + at) / (p.rate * p.rate), 1};
  if (options.outlier_density == OutlierDensity::kWindow) {
    const Lanes length =
        MuStep(p, Load(block.last + at) - 0.5F) - MuStep(p, Load(block.first + at) + 0.5F);
    m.u = 1.0F / Clamp(length, Lanes(1e-6F), Lanes(1.0F));
  }
  return m;
}

/// The counts of the seeds after a frame of that status.
CountsOf<Lanes> Counted(const SeedLanes& s,
                        const Lanes& status,
                        const Mask& told,
                        const Mask& agreed) {
  constexpr float kMostViews = 255, kMostAge = 65535;
  const Lanes one = 1.0F, none = 0.0F;
  CountsOf<Lanes> counts;
  counts.age = Min(s.counts.age + Select(told, one, none), kMostAge);
  counts.views = Min(s.counts.views + Select(agreed, one, none), kMostViews);
  counts.unseen = Select(
      status == Number(MatchStatus::kOutOfView), Min(s.counts.unseen + one, kMostViews), none);
  return counts;
}

/// Writes the state of the seeds that were alive back.
void StoreState(const SeedLanes& was,
                const Posterior<Lanes>& q,
                const CountsOf<Lanes>& counts,
                const Lanes& fate,
                const SeedColumns& s,
                std::size_t begin) {
  const int n = was.count;
  const auto store = [&](const Lanes& now, const Lanes& before, float* p) {
    Store(Select(was.alive, now, before), p + begin, n);
  };
  store(q.mu, was.q.mu, s.mu);
  store(q.sigma2, was.q.sigma2, s.sigma2);
  store(q.a, was.q.a, s.a);
  store(q.b, was.q.b, s.b);
  const Int word = ToInt(counts.age) | (ToInt(counts.views) << 16) | (ToInt(counts.unseen) << 24);
  const Int old = LoadInt(s.counts + begin, n);
  StoreInt((was.alive.bits & word) | (~was.alive.bits & old), s.counts + begin, n);
  const Int old_fate = LoadBytes(s.fate + begin, n);
  StoreBytes((was.alive.bits & ToInt(fate)) | (~was.alive.bits & old_fate), s.fate + begin, n);
}

/// Number of seeds by MatchStatus.
using StatusCounts = std::int64_t[4];

/// [VH11] Algorithm 1, step 2c, and the judgement of steps 3 and 4, for the seeds from `begin` on,
/// which are entries `at` ... of the block.
void Finish(const UpdateJob& job,
            std::size_t begin,
            std::size_t end,
            const BlockSearch& block,
            int at,
            StatusCounts* count) {
  const Options& options = *job.options;
  const SeedLanes s(job.seeds, begin, end);
  Lanes status = Load(block.status + at);
  const Measurement m = Conclude(job, block, at, s.q.mu, &status);
  const auto is = [&](MatchStatus v) { return status == Number(v); };
  const Mask matched = is(MatchStatus::kMatched), missed = is(MatchStatus::kMismatch);
  const Mask born = Everywhere(options.search != Search::kFull) | (s.counts.views > 0.0F);

  const Fused<Lanes> fused = Fuse(s.q, m.x, m.tau2, m.u);
  const Mask fuses = matched & born, starts = matched & ~born;
  const auto choose = [&](const Lanes& fuse, const Lanes& start, const Lanes& otherwise) {
    return Select(fuses, fuse, Select(starts, start, otherwise));
  };
  // Differs from [VH11]: where one frame's step is wider than any window, the best match on the
  // whole line is the hypothesis that the next frames put to the test.
  Posterior<Lanes> q;
  q.mu = choose(fused.posterior.mu, m.x, s.q.mu);
  q.sigma2 = choose(fused.posterior.sigma2, kBirthSigmas * kBirthSigmas * m.tau2, s.q.sigma2);
  q.a = choose(fused.posterior.a, s.q.a + 1.0F, s.q.a);
  q.b = choose(fused.posterior.b, s.q.b, Select(missed, Miss(s.q).b, s.q.b));

  // A camera at rest ages nobody; a patch that cannot be matched wherever the camera goes, does.
  const Mask parallax = Load(block.parallax + at) > 0.0F;
  const Mask told = matched | missed | (is(MatchStatus::kNoInformation) & (parallax | ~born));
  const Mask agreed = (fuses & (fused.inlier_weight > 0.5F)) | starts;
  const CountsOf<Lanes> counts = Counted(s, status, told, agreed);

  const Lanes total_sigma2 =
      Select(matched,
             TotalVariance(q.sigma2, Load(block.bias2_px + at), 1.0F / Load(block.rate + at)),
             -1.0F);
  Lanes fate = JudgeNumber(
      options, *job.is_outlier, s.interval, q, counts, total_sigma2, job.group->pixel_width);
  const Mask stillborn = ~born & (counts.views <= 0.0F) & (counts.age >= kBirthTries);
  fate = Select(stillborn, Number(Fate::kOutlier), fate);
  q.sigma2 = Select(fate == Number(Fate::kConverged), total_sigma2, q.sigma2);
  StoreState(s, q, counts, fate, job.seeds, begin);
  for (int v = 0; v < 4; ++v) {
    (*count)[v] += Count(s.alive & is(static_cast<MatchStatus>(v)));
  }
}

/// Updates seeds [begin, end), kBlock at most, and counts them by status.
template <typename Model>
void UpdateBlock(const UpdateJob& job, std::size_t begin, std::size_t end, StatusCounts* count) {
  BlockSearch block;
  const int seeds = static_cast<int>(end - begin);
  for (int at = 0; at < seeds; at += kLanes) Prepare<Model>(job, begin + at, end, at, &block);
  const SearchOrder order(block, seeds);
  for (int first = 0; first < order.size(); first += kLanes) {
    if (job.warp) {
      SearchEntries<WarpedSampler>(job, begin, order.At(first), &block);
    } else {
      SearchEntries<AlignedSampler>(job, begin, order.At(first), &block);
    }
  }
  for (int at = 0; at < seeds; at += kLanes) Finish(job, begin + at, end, block, at, count);
}

}  // namespace

UpdateStatistics Update(const UpdateJob& job, std::size_t begin, std::size_t end) {
  StatusCounts count = {};
  VisitModel(job.model, [&](auto model) {
    for (std::size_t i = begin; i < end; i += kBlock) {
      UpdateBlock<decltype(model)>(job, i, std::min(i + kBlock, end), &count);
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
