#include "livemvs/reference/matcher.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace livemvs::reference {
namespace {

// Step of the central differences in mu. Second-order error 1e-10, rounding 1e-16 f / 1e-5.
constexpr double kStep = 1e-5;

// Clearance of samples from the border beside the patch itself: the half-pixel step of the
// refinement and the right neighbour of the interpolation [px].
constexpr double kInterpolation = 1.5;

using Vector2d = Eigen::Vector2d;

// The epipolar line near the prior mean, all by sampling the projection.
class Line {
 public:
  Line(const Options& options, const Seed& seed, const Meeting& current)
      : options_(options), seed_(seed), current_(current) {
    const auto here = At(seed.posterior.mu);
    const auto ahead = At(seed.posterior.mu + kStep), behind = At(seed.posterior.mu - kStep);
    visible_ = here && ahead && behind;
    if (!visible_) return;
    origin_ = *here;
    const Vector2d velocity = (*ahead - *behind) / (2 * kStep);
    rate_ = velocity.norm();
    direction_ = rate_ > 0 ? Vector2d(velocity / rate_) : Vector2d(0, 0);
  }

  bool visible() const { return visible_; }
  const Vector2d& origin() const { return origin_; }
  const Vector2d& direction() const { return direction_; }
  double rate() const { return rate_; }

  // Where the ray's point at mu projects to: through the world.
  std::optional<Vector2d> At(double mu) const {
    const double depth = DepthAt(options_, seed_, mu);
    if (!(depth > 0)) return std::nullopt;
    const Eigen::Vector3d bearing =
        Eigen::Vector3d(seed_.bearing_x, seed_.bearing_y, 1).normalized();
    const Eigen::Vector3d world = seed_.cam_from_world.Inverse() * (bearing * depth);
    return current_.projector.Project(current_.cam_from_world * world);
  }

  // Signed distance along the line of the projection at mu, infinite where there is none.
  double Offset(double mu) const {
    const auto p = At(mu);
    if (!p) return std::copysign(std::numeric_limits<double>::infinity(), mu - seed_.posterior.mu);
    return direction_.dot(*p - origin_);
  }

  // The mu whose projection lies at `offset`: bracketed by doubling, then bisected.
  double MuAt(double offset) const {
    if (offset == 0) return seed_.posterior.mu;
    const double mu = seed_.posterior.mu;
    const double sign = offset > 0 ? 1 : -1;
    double inside = 0, outside = 1e-6;
    while (std::abs(Offset(mu + sign * outside)) < std::abs(offset) && outside < 1e6) outside *= 2;
    for (int i = 0; i < 50; ++i) {
      const double middle = (inside + outside) / 2;
      (std::abs(Offset(mu + sign * middle)) < std::abs(offset) ? inside : outside) = middle;
    }
    return mu + sign * inside;
  }

 private:
  const Options& options_;
  const Seed& seed_;
  const Meeting& current_;
  bool visible_ = false;
  Vector2d origin_, direction_;
  double rate_ = 0;
};

// How the patch lies in the current image.
struct Grid {
  Vector2d right;  // Step per pixel to the right in the patch ...
  Vector2d down;   // ... and down.
  double scale;    // Of the patch, current over reference, whether or not the grid follows.
};

Grid GridOf(const Options& options, const Seed& seed, const Meeting& current) {
  const Rigid3d cur_from_ref = current.cam_from_world * seed.cam_from_world.Inverse();
  const Eigen::Vector3d bearing = Eigen::Vector3d(seed.bearing_x, seed.bearing_y, 1).normalized();
  const Eigen::Vector3d in_ref = bearing * DepthAt(options, seed, seed.posterior.mu);
  const double focal_ratio =
      std::sqrt(std::abs(current.projector.camera().fx * current.projector.camera().fy /
                         (seed.camera.fx * seed.camera.fy)));
  const double scale =
      std::clamp(focal_ratio * in_ref.z() / (cur_from_ref * in_ref).z(), 0.25, 4.0);
  if (!current.warp) return {{1, 0}, {0, 1}, scale};
  const Eigen::Matrix3d& r = cur_from_ref.rotation;
  double roll = std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1));
  if (current.projector.camera().fy < 0) roll = -roll;  // both pictures are mirrored
  const Vector2d right(scale * std::cos(roll), scale * std::sin(roll));
  return {right, {-right.y(), right.x()}, scale};
}

// NCC from its definition: means first, then the sums of products.
double Ncc(const Seed& seed, const Meeting& current, const Grid& grid, const Vector2d& center) {
  std::array<double, kPatchPixels> w{};
  double mean_w = 0, mean_p = 0;
  for (int r = 0; r < kPatchSize; ++r) {
    for (int c = 0; c < kPatchSize; ++c) {
      const int i = r * kPatchSize + c;
      w[i] = Bilinear(current.image,
                      center + (c - kPatchRadius) * grid.right + (r - kPatchRadius) * grid.down);
      mean_w += w[i] / kPatchPixels;
      mean_p += seed.patch[i] / static_cast<double>(kPatchPixels);
    }
  }
  double ww = 0, pp = 0, wp = 0;
  for (int i = 0; i < kPatchPixels; ++i) {
    ww += (w[i] - mean_w) * (w[i] - mean_w);
    pp += (seed.patch[i] - mean_p) * (seed.patch[i] - mean_p);
    wp += (w[i] - mean_w) * (seed.patch[i] - mean_p);
  }
  return wp / std::sqrt(std::max(ww, 1.0) * pp);  // no contrast, no match
}

// Variances in pixels, docs/algorithm.md.
struct Variances {
  double match;   // of one match: the matcher's own, the image noise's share, and the slip's
  double shared;  // of the error that all matches share: the bias, and the slip's
};

// What is left of `values` when the share that the patch's own grey levels and a constant explain
// is taken off: by the normal equations of least squares.
std::vector<double> WithoutGainAndOffset(const std::vector<double>& values,
                                         const std::vector<double>& grey) {
  Eigen::MatrixX2d basis(grey.size(), 2);
  for (std::size_t i = 0; i < grey.size(); ++i) basis.row(static_cast<int>(i)) << 1, grey[i];
  const Eigen::Map<const Eigen::VectorXd> v(values.data(), static_cast<int>(values.size()));
  const Eigen::VectorXd rest = v - basis * basis.completeOrthogonalDecomposition().solve(v);
  return {rest.data(), rest.data() + rest.size()};
}

Variances VariancesOf(const Options& options,
                      const Seed& seed,
                      const Vector2d& direction,
                      double noise) {
  const Vector2d across(-direction.y(), direction.x());
  std::vector<double> grey, g, h;
  for (int r = 1; r < kPatchSize - 1; ++r) {
    for (int c = 1; c < kPatchSize - 1; ++c) {
      const auto at = [&](int y, int x) {
        return static_cast<double>(seed.patch[y * kPatchSize + x]);
      };
      const Vector2d gradient((at(r, c + 1) - at(r, c - 1)) / 2, (at(r + 1, c) - at(r - 1, c)) / 2);
      grey.push_back(at(r, c));
      g.push_back(gradient.dot(direction));
      h.push_back(gradient.dot(across));
    }
  }
  g = WithoutGainAndOffset(g, grey);
  h = WithoutGainAndOffset(h, grey);
  double gg = 0, gh = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    gg += g[i] * g[i];
    gh += g[i] * h[i];
  }
  const double scale = kPatchPixels / static_cast<double>(g.size());
  const double noise2 = noise * noise;
  // Central differences hold half of the noise's variance; two degrees of freedom are taken off.
  const double noise_share = noise2 / 2 * static_cast<double>(g.size() - 2) * scale;
  const double signal = std::max(gg * scale - noise_share, 0.0) + 1e-6;
  // An error across the line moves an edge that crosses it at a slant along it.
  const double slip = std::pow(options.epipolar_error_px * gh * scale / signal, 2);
  const double own = std::pow(static_cast<double>(options.measurement_sigma_px), 2);
  return {own + (noise2 > 0 ? 2 * noise2 / signal : 0) + slip,
          std::pow(options.match_bias_px, 2) + slip};
}

// Whole-pixel samples [first, last] that the window, the interval and the picture allow.
std::pair<int, int> Window(const Line& line, const Meeting& current, double radius, double margin) {
  const double reach = std::ceil(radius) + 2;
  const double from = line.Offset(0) - 1, to = line.Offset(1) + 1;
  int first = 1, last = 0;
  for (int i = static_cast<int>(-reach); i <= static_cast<int>(reach); ++i) {
    const Vector2d p = line.origin() + i * line.direction();
    const bool visited = std::abs(i) <= radius + 1 && i >= from && i <= to &&
                         current.projector.camera().Contains(p, margin);
    if (!visited) continue;
    if (first > last) first = i;
    last = i;
  }
  return {first, last};
}

struct Peaks {
  double best = -2;
  double second = -2;
  double offset = 0;
};

}  // namespace

double Bilinear(const ImageView<std::uint8_t>& image, const Vector2d& p) {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
  const double fx = p.x() - x, fy = p.y() - y;
  return (1 - fx) * (1 - fy) * image(x, y) + fx * (1 - fy) * image(x + 1, y) +
         (1 - fx) * fy * image(x, y + 1) + fx * fy * image(x + 1, y + 1);
}

double DepthAt(const Options& options, const Seed& seed, double mu) {
  const double c = seed.interval.c0 + mu * (seed.interval.c1 - seed.interval.c0);
  return options.coordinate == DepthCoordinate::kDepth ? c : 1 / c;
}

namespace {

Peaks FindPeaks(const std::vector<double>& score, int first) {
  Peaks peaks;
  for (std::size_t i = 1; i + 1 < score.size(); ++i) {
    if (!(score[i] > score[i - 1] && score[i] >= score[i + 1])) continue;
    if (score[i] > peaks.best) {
      peaks.second = peaks.best;
      peaks.best = score[i];
      peaks.offset = first + static_cast<double>(i);
    } else {
      peaks.second = std::max(peaks.second, score[i]);
    }
  }
  return peaks;
}

}  // namespace

Match FindMatch(const Options& options, const Seed& seed, const Meeting& current) {
  const Line line(options, seed, current);
  if (!line.visible()) return {MatchStatus::kOutOfView};
  const double sigma_px = std::sqrt(seed.posterior.sigma2) * line.rate();
  if (4 * sigma_px < options.min_parallax_px || line.rate() == 0) {
    const bool inside = current.projector.camera().Contains(line.origin());
    return {inside ? MatchStatus::kNoInformation : MatchStatus::kOutOfView};
  }
  const auto without_match = [](MatchStatus status) {
    Match match{status};
    match.had_parallax = true;
    return match;
  };
  const Grid grid = GridOf(options, seed, current);
  const double radius =
      std::min(std::max<double>(options.search_sigmas * sigma_px, options.search_radius_px),
               static_cast<double>(options.search_radius_max_px));
  const double reach = current.warp ? kPatchRadius * 1.4143 * grid.scale : kPatchRadius;
  const auto [first, last] = Window(line, current, radius, reach + kInterpolation);
  if (last - first < 2) return without_match(MatchStatus::kOutOfView);
  const Vector2d in_patch(grid.right.normalized().dot(line.direction()),
                          grid.down.normalized().dot(line.direction()));
  const Variances variances =
      VariancesOf(options, seed, in_patch, std::ldexp(options.image_noise, -current.level));
  if (std::sqrt(variances.match) > options.max_measurement_sigma_px)
    return without_match(MatchStatus::kNoInformation);
  if (std::all_of(
          seed.patch.begin(), seed.patch.end(), [&](auto v) { return v == seed.patch[0]; })) {
    return without_match(MatchStatus::kNoInformation);
  }

  const auto score_at = [&](double offset) {
    return Ncc(seed, current, grid, line.origin() + offset * line.direction());
  };
  std::vector<double> score;
  for (int i = first; i <= last; ++i) score.push_back(score_at(i));
  const Peaks peaks = FindPeaks(score, first);
  if (peaks.best <= -2 || peaks.best < options.min_ncc)
    return without_match(MatchStatus::kMismatch);
  if (options.ambiguity_ncc > 0 && peaks.second > peaks.best - options.ambiguity_ncc) {
    return without_match(MatchStatus::kNoInformation);
  }
  Match match{MatchStatus::kMatched,
              peaks.best,
              peaks.offset,
              0,
              0,
              1,
              1 / line.rate(),
              variances.shared,
              true};
  // The parabola through three samples half a pixel apart.
  const double low = score_at(peaks.offset - 0.5), high = score_at(peaks.offset + 0.5);
  const double curvature = low - 2 * peaks.best + high;
  if (curvature < 0) match.offset += std::clamp((low - high) / (4 * curvature), -0.5, 0.5);
  match.mu = line.MuAt(match.offset);
  match.tau2 = variances.match / (line.rate() * line.rate());
  if (options.outlier_density == OutlierDensity::kWindow) {
    match.u = 1 / std::clamp(line.MuAt(last - 0.5) - line.MuAt(first + 0.5), 1e-6, 1.0);
  }
  return match;
}

}  // namespace livemvs::reference
