#include "livemvs/reference/ncc_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "livemvs/core/seed.h"

namespace livemvs::reference {
namespace {

using Eigen::Vector2d;

// The patch's reach and the right neighbour of the interpolation [px].
constexpr double kBorder = kPatchRadius + 1;

// Most steps on a ray: it bounds the work where the ray's projection races through the picture.
constexpr double kMostSteps = 1e5;
// Fewest steps on a ray, also where its projection stands still.
constexpr double kFewestSteps = 32;

struct Sample {
  double depth;
  double score;
};

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

// All pixels of an unwarped patch have the same fractional part, so one set of weights will do.
double Ncc(const RayPatch& ray, const ImageView<std::uint8_t>& image, const Vector2d& center) {
  const int x = static_cast<int>(std::floor(center.x())),
            y = static_cast<int>(std::floor(center.y()));
  const double fx = center.x() - x, fy = center.y() - y;
  std::array<double, kPatchPixels> w{};
  double mean_w = 0;
  for (int i = 0; i < kPatchPixels; ++i) {
    const int c = x + i % kPatchSize - kPatchRadius, r = y + i / kPatchSize - kPatchRadius;
    w[i] = (1 - fy) * ((1 - fx) * image(c, r) + fx * image(c + 1, r)) +
           fy * ((1 - fx) * image(c, r + 1) + fx * image(c + 1, r + 1));
    mean_w += w[i] / kPatchPixels;
  }
  const double mean_p = Mean(ray.patch);
  double ww = 0, pp = 0, wp = 0;
  for (int i = 0; i < kPatchPixels; ++i) {
    ww += (w[i] - mean_w) * (w[i] - mean_w);
    pp += (ray.patch[i] - mean_p) * (ray.patch[i] - mean_p);
    wp += (w[i] - mean_w) * (ray.patch[i] - mean_p);
  }
  return wp / std::sqrt(std::max(ww, 1.0) * pp);  // no contrast, no match
}

// Where the ray runs in the neighbour's picture.
class Trace {
 public:
  Trace(const RayPatch& ray, const PosedView& neighbour, double range)
      : ray_(ray), neighbour_(neighbour), difference_(1e-6 * range) {}

  std::optional<Vector2d> At(double depth) const {
    return neighbour_.projector.Project(neighbour_.cam_from_world * ray_.At(depth));
  }

  // Pixels per unit of depth, by a central difference; 0 where there is no projection.
  double Rate(double depth) const {
    const auto behind = At(depth - difference_), ahead = At(depth + difference_);
    return behind && ahead ? (*ahead - *behind).norm() / (2 * difference_) : 0;
  }

  // A step in depth that moves the projection by at most `step_px`.
  double Step(double depth, double step_px, double range) const {
    const double rate = Rate(depth);
    double step = std::min(range / kFewestSteps, rate > 0 ? step_px / rate : range);
    const auto from = At(depth);
    for (int i = 0; from && i < 32; ++i) {
      const auto to = At(depth + step);
      if (to && (*to - *from).norm() <= step_px) break;
      step *= to ? 0.8 : 0.5;
    }
    return std::max(step, range / kMostSteps);
  }

 private:
  const RayPatch& ray_;
  const PosedView& neighbour_;
  double difference_;
};

// The vertex of the parabola through three samples, the middle one above the others.
Sample Vertex(const Sample& a, const Sample& b, const Sample& c) {
  const double slope_ab = (b.score - a.score) / (b.depth - a.depth);
  const double slope_bc = (c.score - b.score) / (c.depth - b.depth);
  const double curvature = (slope_bc - slope_ab) / (c.depth - a.depth);
  if (!(curvature < 0)) return b;
  const double depth = (a.depth + b.depth) / 2 - slope_ab / (2 * curvature);
  const double score =
      a.score + slope_ab * (depth - a.depth) + curvature * (depth - a.depth) * (depth - b.depth);
  return {depth, score};
}

}  // namespace

double RayPatch::Contrast() const {
  const double mean = Mean(patch);
  double sum = 0;
  for (const double v : patch) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(patch.size()));
}

RayPatch MakeRayPatch(const PosedView& reference, int x, int y) {
  const ImageView<std::uint8_t>& image = reference.image;
  const auto ray = reference.projector.Unproject({x, y});
  if (!ray || x < kPatchRadius || y < kPatchRadius || x >= image.width - kPatchRadius ||
      y >= image.height - kPatchRadius) {
    throw std::invalid_argument("pixel (" + std::to_string(x) + ", " + std::to_string(y) +
                                ") has no ray, or its patch is not in the picture");
  }
  RayPatch result;
  result.origin = reference.cam_from_world.Center();
  result.direction = reference.cam_from_world.rotation.transpose() * ray->normalized();
  for (int i = 0; i < kPatchPixels; ++i) {
    result.patch.push_back(
        image(x + i % kPatchSize - kPatchRadius, y + i / kPatchSize - kPatchRadius));
  }
  return result;
}

NccCurve TraceNcc(const RayPatch& ray,
                  const PosedView& neighbour,
                  double z_min,
                  double z_max,
                  double max_step_px) {
  if (!(z_min < z_max) || !(max_step_px > 0)) {
    throw std::invalid_argument("a curve needs z_min < z_max and a positive step");
  }
  NccCurve curve;
  if (ray.Contrast() == 0) return curve;
  const Trace trace(ray, neighbour, z_max - z_min);
  std::vector<Sample> run;  // samples since the ray came into view
  for (double z = z_min; z <= z_max; z += trace.Step(z, max_step_px, z_max - z_min)) {
    const auto pixel = trace.At(z);
    if (!pixel || !neighbour.projector.camera().Contains(*pixel, kBorder)) {
      run.clear();
      continue;
    }
    run.push_back({z, Ncc(ray, neighbour.image, *pixel)});
    curve.depths.push_back(run.back().depth);
    curve.scores.push_back(run.back().score);
    if (run.size() < 3) continue;
    const Sample &a = run[run.size() - 3], &b = run[run.size() - 2], &c = run.back();
    if (!(b.score > a.score && b.score >= c.score)) continue;
    const Sample top = Vertex(a, b, c);
    const double rate = trace.Rate(top.depth);
    if (rate > 0) curve.maxima.push_back({top.depth, top.score, 1 / rate});
  }
  return curve;
}

}  // namespace livemvs::reference
