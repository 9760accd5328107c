#include "livemvs/reference/algorithm1.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "livemvs/reference/matcher.h"
#include "livemvs/reference/posterior.h"
#include "livemvs/reference/side_check.h"

namespace livemvs::reference {
namespace {

// Half of the prior's interval is this many standard deviations: 99 % within, [VH11] Sec. 4.2.
constexpr double kSigmas99 = 2.5758;

// Mean and standard deviation along the ray [scene], first order.
std::pair<double, double> DepthAndSigma(const Options& options, const Seed& seed) {
  const double step = 1e-6;
  const double sigma = std::sqrt(seed.posterior.sigma2);
  const double rate = (DepthAt(options, seed, seed.posterior.mu + step) -
                       DepthAt(options, seed, seed.posterior.mu - step)) /
                      (2 * step);
  return {DepthAt(options, seed, seed.posterior.mu), std::abs(rate) * sigma};
}

// With the error that all matches of a seed share (docs/algorithm.md).
double TotalVariance(const Seed& seed, const Match& match) {
  return seed.posterior.sigma2 + match.bias2_px * match.step * match.step;
}

// [VH11] Sec. 4.3, with our further criteria (docs/algorithm.md).
Fate JudgeSeed(const Options& options, const Seed& seed, const Match& match) {
  const Posterior<double>& q = seed.posterior;
  if (!(q.mu > -0.1 && q.mu < 1.1)) return Fate::kLeftInterval;
  if (options.eta_outlier > 0 &&
      BetaCdf(options.eta_outlier, q.a, q.b) > options.outlier_certainty) {
    return Fate::kOutlier;
  }
  if (match.status == MatchStatus::kMatched && InlierRatio(q) > options.eta_inlier &&
      seed.counts.views >= options.min_views) {
    Seed widened = seed;
    widened.posterior.sigma2 = TotalVariance(seed, match);
    const auto [depth, sigma] = DepthAndSigma(options, widened);
    const double range = std::abs(DepthAt(options, seed, 1) - DepthAt(options, seed, 0));
    const double pixel = depth / std::sqrt(std::abs(seed.camera.fx * seed.camera.fy));
    if (sigma < options.epsilon_range * range || sigma < options.epsilon_px * pixel) {
      return q.mu >= 0 && q.mu <= 1 ? Fate::kConverged : Fate::kLeftInterval;
    }
  }
  if (options.max_age > 0 && seed.counts.age >= options.max_age) return Fate::kAged;
  if (options.max_unseen > 0 && seed.counts.unseen >= options.max_unseen) return Fate::kUnseen;
  return Fate::kAlive;
}

double InlierWeight(const Posterior<double>& q, const Match& match) {
  const double v = q.sigma2 + match.tau2, d = match.mu - q.mu;
  const double good = q.a * std::exp(-d * d / (2 * v)) / std::sqrt(2 * M_PI * v);
  return good / (good + q.b * match.u);
}

double PatchVariance(const Seed& seed) {
  double mean = 0, variance = 0;
  for (const auto v : seed.patch) mean += v / static_cast<double>(kPatchPixels);
  for (const auto v : seed.patch) variance += (v - mean) * (v - mean) / kPatchPixels;
  return variance;
}

// Distance from the patch's middle to the centroid of its squared gradient, taken between each four
// pixels and less the share of the noise [px].
double TextureOffset(const Options& options, const Seed& seed) {
  const double noise2 = std::pow(options.image_noise, 2);
  const auto grey = [&](int x, int y) {
    return static_cast<double>(seed.patch[y * kPatchSize + x]);
  };
  double sum = 0;
  Eigen::Vector2d moment(0, 0);
  for (int y = 0; y + 1 < kPatchSize; ++y) {
    for (int x = 0; x + 1 < kPatchSize; ++x) {
      const double gx = (grey(x + 1, y) - grey(x, y) + grey(x + 1, y + 1) - grey(x, y + 1)) / 2;
      const double gy = (grey(x, y + 1) - grey(x, y) + grey(x + 1, y + 1) - grey(x + 1, y)) / 2;
      const double texture = std::max(gx * gx + gy * gy - 2 * noise2, 0.0);
      sum += texture;
      moment += texture * Eigen::Vector2d(x + 0.5 - kPatchRadius, y + 0.5 - kPatchRadius);
    }
  }
  return sum > 0 ? moment.norm() / sum : 0;
}

// Whether a seed is to meet a frame with that pose (Options::min_move).
bool Meets(const Options& options, const Seed& seed, const Rigid3d& cam_from_world) {
  if (options.min_move == 0 || seed.left_out > kMostLeftOut) return true;
  const double moved = (cam_from_world * seed.last_met.Inverse()).translation.norm();
  const double baseline = (cam_from_world * seed.cam_from_world.Inverse()).translation.norm();
  return moved > options.min_move * baseline;
}

}  // namespace

Match UpdateSeed(const Options& options, const Meeting& current, Seed* seed) {
  const Match match = FindMatch(options, *seed, current);
  SeedCounts& counts = seed->counts;
  if (match.status == MatchStatus::kMatched) {
    const double w1 = InlierWeight(seed->posterior, match);
    seed->posterior = FuseTextbook(seed->posterior, match.mu, match.tau2, match.u);
    if (w1 > 0.5 && counts.views < 255) ++counts.views;
  } else if (match.status == MatchStatus::kMismatch) {
    seed->posterior.b += 1;
  }
  if (match.status == MatchStatus::kMatched || match.status == MatchStatus::kMismatch ||
      (match.status == MatchStatus::kNoInformation && match.had_parallax)) {
    ++counts.age;
  }
  if (match.status != MatchStatus::kOutOfView) {
    counts.unseen = 0;
  } else if (counts.unseen < 255) {
    ++counts.unseen;
  }
  seed->fate = JudgeSeed(options, *seed, match);
  if (seed->fate == Fate::kConverged) {
    seed->posterior.sigma2 = TotalVariance(*seed, match);
  }
  return match;
}

Seed MakeSeed(
    const Options& options, const PosedFrame& frame, int x, int y, double near, double far) {
  Seed seed;
  seed.camera = frame.camera;
  seed.cam_from_world = frame.cam_from_world;
  seed.last_met = frame.cam_from_world;
  const Eigen::Vector3d ray =
      Projector(frame.camera).Unproject({x, y}).value_or(Eigen::Vector3d(0, 0, 1));
  seed.bearing_x = ray.x();
  seed.bearing_y = ray.y();
  const double z0 = near * ray.norm(), z1 = far * ray.norm();
  const bool depth = options.coordinate == DepthCoordinate::kDepth;
  seed.interval = {depth ? z0 : 1 / z0, depth ? z1 : 1 / z1};
  seed.posterior = {0.5, std::pow(0.5 / kSigmas99, 2), options.prior_a, options.prior_b};
  for (int r = 0; r < kPatchSize; ++r) {
    for (int c = 0; c < kPatchSize; ++c) {
      seed.patch[r * kPatchSize + c] =
          frame.picture->grey(x + c - kPatchRadius, y + r - kPatchRadius);
    }
  }
  return seed;
}

Algorithm1::Algorithm1(const Options& options, double near, double far)
    : options_(options), near_(near), far_(far) {
  options.Check();
}

std::size_t Algorithm1::AddFrame(const PosedFrame& frame) {
  const std::size_t before = points_.size();
  const Meeting current = {
      frame.picture->grey.view(), Projector(frame.camera), frame.cam_from_world, false};
  for (Seed& seed : seeds_) {  // step 2
    ++seed.left_out;
    if (!Meets(options_, seed, frame.cam_from_world)) continue;
    UpdateSeed(options_, current, &seed);
    seed.last_met = frame.cam_from_world;
    seed.left_out = 0;
    ++updates_;
  }
  for (const Seed& seed : seeds_) {  // steps 3 and 4
    if (seed.fate == Fate::kConverged && SidesMatch(options_, seed, current)) Convert(seed);
  }
  std::erase_if(seeds_, [](const Seed& seed) { return seed.fate != Fate::kAlive; });
  Plant(frame);  // step 1, after the others: a seed tells nothing in the frame it was born in
  return points_.size() - before;
}

void Algorithm1::Plant(const PosedFrame& frame) {
  const int step = options_.seed_spacing_px;
  constexpr int kBorder = kPatchRadius + 1;
  for (int y = kBorder; y < frame.camera.height - kBorder; ++y) {
    for (int x = kBorder; x < frame.camera.width - kBorder; ++x) {
      if (static_cast<int>(seeds_.size()) >= options_.max_seeds) return;
      if (x % step != 0 || y % step != 0) continue;
      const Seed seed = MakeSeed(options_, frame, x, y, near_, far_);
      if (std::sqrt(PatchVariance(seed)) < options_.min_patch_stddev) continue;
      const double most = options_.max_texture_offset_px;
      if (most == 0 || TextureOffset(options_, seed) <= most) seeds_.push_back(seed);
    }
  }
}

void Algorithm1::Convert(const Seed& seed) {
  const auto [depth, sigma] = DepthAndSigma(options_, seed);
  const Eigen::Vector3d bearing = Eigen::Vector3d(seed.bearing_x, seed.bearing_y, 1).normalized();
  const Rigid3d world_from_ref = seed.cam_from_world.Inverse();
  Point point;
  point.position = (world_from_ref * (bearing * depth)).cast<float>();
  point.normal = -(world_from_ref.rotation * bearing).cast<float>();
  point.sigma = static_cast<float>(sigma);
  point.inlier_ratio = static_cast<float>(InlierRatio(seed.posterior));
  point.views = seed.counts.views;
  points_.push_back(point);
}

}  // namespace livemvs::reference
