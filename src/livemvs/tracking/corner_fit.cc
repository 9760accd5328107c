#include "livemvs/tracking/corner_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace livemvs {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kMaxPatch = 64;  // side of the copied neighbourhood [averaged px]
constexpr int kMaxHalf = 10;   // samples on each side of the centre
constexpr int kMaxIterations = 12;
constexpr double kMinRadius = 1.8;   // [averaged px] below it there is nothing to compare
constexpr double kSmoothing = 0.5;   // variance of the (1 2 1) / 4 filter [px²]
constexpr double kSeparation = 0.3;  // of the darkest white from the brightest black, of contrast

// A neighbourhood of the picture, averaged and smoothed by (1 2 1) / 4 both ways, which makes
// interpolation between its pixels accurate.
class Patch {
 public:
  // Covers center ± half in averaged pixels. False where that leaves the picture or is too large.
  bool Load(ImageView<std::uint8_t> image, int scale, const Vector2d& center, double half) {
    x0_ = static_cast<int>(std::floor(center.x() - half)) - 1;
    y0_ = static_cast<int>(std::floor(center.y() - half)) - 1;
    width_ = static_cast<int>(std::ceil(center.x() + half)) + 2 - x0_;
    height_ = static_cast<int>(std::ceil(center.y() + half)) + 2 - y0_;
    if (x0_ < 0 || y0_ < 0 || width_ > kMaxPatch || height_ > kMaxPatch ||
        (x0_ + width_) * scale > image.width || (y0_ + height_) * scale > image.height) {
      return false;
    }
    const float weight = 1.f / static_cast<float>(scale * scale);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        int sum = 0;
        for (int i = 0; i < scale; ++i) {
          const std::uint8_t* row = image.Row((y0_ + y) * scale + i) + (x0_ + x) * scale;
          for (int j = 0; j < scale; ++j) sum += row[j];
        }
        value_[y][x] = static_cast<float>(sum) * weight;
      }
    }
    Smooth();
    return true;
  }

  bool Covers(const Vector2d& p) const {
    return p.x() >= x0_ + 1 && p.y() >= y0_ + 1 && p.x() < x0_ + width_ - 2 &&
           p.y() < y0_ + height_ - 2;
  }

  struct Sample {
    float value, dx, dy;
  };

  // Bilinear; the place must be covered.
  Sample At(const Vector2d& p) const {
    const double u = p.x() - x0_, v = p.y() - y0_;
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const float fx = static_cast<float>(u - x), fy = static_cast<float>(v - y);
    const float a = value_[y][x], b = value_[y][x + 1];
    const float c = value_[y + 1][x], d = value_[y + 1][x + 1];
    const float top = a + fx * (b - a), bottom = c + fx * (d - c);
    return {top + fy * (bottom - top), (b - a) + fy * ((d - c) - (b - a)), bottom - top};
  }

 private:
  void Smooth() {
    for (int y = 0; y < height_; ++y) {
      float left = value_[y][0];
      for (int x = 1; x + 1 < width_; ++x) {
        const float here = value_[y][x];
        value_[y][x] = 0.25f * (left + value_[y][x + 1]) + 0.5f * here;
        left = here;
      }
    }
    std::array<float, kMaxPatch> above;
    std::copy_n(value_[0].begin(), width_, above.begin());
    for (int y = 1; y + 1 < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const float here = value_[y][x];
        value_[y][x] = 0.25f * (above[x] + value_[y + 1][x]) + 0.5f * here;
        above[x] = here;
      }
    }
  }

  int x0_ = 0, y0_ = 0, width_ = 0, height_ = 0;
  std::array<std::array<float, kMaxPatch>, kMaxPatch> value_;
};

// The samples' places without the shift: half of them, each with its opposite.
struct Grid {
  struct Pair {
    Vector2d place, opposite;  // [averaged px]
    double weight;
  };
  std::array<Pair, (2 * kMaxHalf + 1) * (2 * kMaxHalf + 1) / 2> pairs;
  int count = 0;
  double sample_area = 0;             // [averaged px²]
  Vector2d across_x, across_y;        // unit normals of the edges along y and x
  double length_x = 0, length_y = 0;  // of the edges within the grid [averaged px]
};

Vector2d Averaged(const Vector2d& pixel, int scale) {
  return ((pixel.array() + 0.5) / scale - 0.5).matrix();
}

// @return False where the pattern is seen too small.
bool MakeGrid(const CornerView& view,
              const CornerGeometry& geometry,
              const CornerFitOptions& o,
              Grid* grid) {
  constexpr double kStep = 1e-4;  // of the derivative [m]
  const Vector2d center = view.Pixel(0, 0);
  const Vector2d along_x = (view.Pixel(kStep, 0) - center) / (kStep * o.scale);
  const Vector2d along_y = (view.Pixel(0, kStep) - center) / (kStep * o.scale);
  const double rx = std::min(geometry.radius, o.radius_px / along_x.norm());
  const double ry = std::min(geometry.radius, o.radius_px / along_y.norm());
  // NaN and infinities of a degenerate view fail here too.
  if (!(rx * along_x.norm() >= kMinRadius && ry * along_y.norm() >= kMinRadius)) return false;
  const int nx = std::clamp(static_cast<int>(std::lround(rx * along_x.norm())), 2, kMaxHalf);
  const int ny = std::clamp(static_cast<int>(std::lround(ry * along_y.norm())), 2, kMaxHalf);
  for (int j = 0; j <= ny; ++j) {
    for (int i = -nx; i <= nx; ++i) {
      if (j == 0 && i <= 0) continue;
      const double a = static_cast<double>(i) / nx, b = static_cast<double>(j) / ny;
      grid->pairs[grid->count++] = {Averaged(view.Pixel(a * rx, b * ry), o.scale),
                                    Averaged(view.Pixel(-a * rx, -b * ry), o.scale),
                                    std::exp(-1.2 * (a * a + b * b))};
    }
  }
  grid->length_x = 2 * ry * along_y.norm();
  grid->length_y = 2 * rx * along_x.norm();
  grid->across_x = Vector2d(-along_y.y(), along_y.x()).normalized();
  grid->across_y = Vector2d(-along_x.y(), along_x.x()).normalized();
  const double cross = std::abs(along_x.x() * along_y.y() - along_x.y() * along_y.x());
  grid->sample_area = cross * (rx / nx) * (ry / ny);
  return true;
}

// How well the picture equals itself turned by half about the shifted centre.
struct Symmetry {
  Matrix2d information = Matrix2d::Zero();
  Vector2d gradient = Vector2d::Zero();
  double squares = 0, weights = 0;
  double steep_x = 0, steep_y = 0;  // sums of squared slopes across the edges
};

std::optional<Symmetry> Compare(const Patch& patch, const Grid& grid, const Vector2d& shift) {
  Symmetry s;
  for (int k = 0; k < grid.count; ++k) {
    const Grid::Pair& pair = grid.pairs[k];
    const Vector2d p = pair.place + shift, q = pair.opposite + shift;
    if (!patch.Covers(p) || !patch.Covers(q)) return std::nullopt;
    const Patch::Sample a = patch.At(p), b = patch.At(q);
    const double residual = a.value - b.value;
    const Vector2d j(a.dx - b.dx, a.dy - b.dy);
    s.information += pair.weight * j * j.transpose();
    s.gradient += pair.weight * residual * j;
    s.squares += pair.weight * residual * residual;
    s.weights += pair.weight;
    for (const Patch::Sample& v : {a, b}) {
      const Vector2d slope(v.dx, v.dy);
      s.steep_x += std::pow(slope.dot(grid.across_x), 2);
      s.steep_y += std::pow(slope.dot(grid.across_y), 2);
    }
  }
  return s;
}

// Contrast of the four squares, nothing where they are not black and white as expected.
std::optional<double> Contrast(const Patch& patch,
                               const CornerView& view,
                               const CornerGeometry& geometry,
                               int scale,
                               const Vector2d& shift) {
  const double d = 0.55 * geometry.margin;
  double lowest_white = 1e9, highest_black = -1e9, sum = 0;
  for (int k = 0; k < 4; ++k) {
    const double sx = (k & 1) != 0 ? d : -d, sy = (k & 2) != 0 ? d : -d;
    const Vector2d p = Averaged(view.Pixel(sx, sy), scale) + shift;
    if (!patch.Covers(p)) return std::nullopt;
    const double value = patch.At(p).value;
    const bool black = (sx * sy > 0) == view.black_up_right;
    if (black) highest_black = std::max(highest_black, value);
    if (!black) lowest_white = std::min(lowest_white, value);
    sum += black ? -value : value;
  }
  const double contrast = 0.5 * sum;
  if (lowest_white - highest_black < kSeparation * contrast) return std::nullopt;
  return contrast;
}

// An edge of height C and Gaussian blur σ has ∫ slope² = C² / (2 √π σ) across it.
double EdgeBlur(double contrast, double length, double steep, double area) {
  const double sigma = contrast * contrast * length /
                       (2 * std::sqrt(std::numbers::pi) * std::max(1e-9, steep * area));
  return std::sqrt(std::max(0.0, sigma * sigma - kSmoothing));
}

}  // namespace

std::optional<CornerFit> FitCorner(ImageView<std::uint8_t> image,
                                   const CornerView& view,
                                   const CornerGeometry& geometry,
                                   const CornerFitOptions& options) {
  Grid grid;
  if (!MakeGrid(view, geometry, options, &grid)) return std::nullopt;
  const Vector2d center = Averaged(view.Pixel(0, 0), options.scale);
  double half = 0;
  for (int k = 0; k < grid.count; ++k) {
    half = std::max(half, (grid.pairs[k].place - center).lpNorm<Eigen::Infinity>());
    half = std::max(half, (grid.pairs[k].opposite - center).lpNorm<Eigen::Infinity>());
  }
  Patch patch;
  if (!patch.Load(image, options.scale, center, half + options.max_shift_px + 1)) {
    return std::nullopt;
  }
  Vector2d shift = Vector2d::Zero();
  std::optional<Symmetry> s;
  double last_step = 1;
  for (int i = 0; i < kMaxIterations && last_step > 2e-3; ++i) {
    s = Compare(patch, grid, shift);
    if (!s || !(s->information.determinant() > 1e-6)) return std::nullopt;
    Vector2d step = -s->information.inverse() * s->gradient;
    if (!step.allFinite()) return std::nullopt;
    last_step = step.norm();
    if (last_step > 1) step /= last_step;
    shift += step;
    if (shift.norm() > options.max_shift_px) return std::nullopt;
  }
  if (last_step > 0.05) return std::nullopt;
  const auto contrast = Contrast(patch, view, geometry, options.scale, shift);
  if (!contrast || *contrast < options.min_contrast) return std::nullopt;
  const double variance = s->squares / s->weights;
  if (std::sqrt(variance) > options.max_asymmetry * *contrast) return std::nullopt;
  CornerFit fit;
  fit.pixel = ((center + shift).array() + 0.5).matrix() * options.scale - Vector2d(0.5, 0.5);
  fit.sigma_px = options.scale * std::sqrt(0.5 * variance * s->information.inverse().trace());
  fit.contrast = *contrast;
  fit.blur_px =
      options.scale * std::max(EdgeBlur(*contrast, grid.length_x, s->steep_x, grid.sample_area),
                               EdgeBlur(*contrast, grid.length_y, s->steep_y, grid.sample_area));
  return fit;
}

}  // namespace livemvs
