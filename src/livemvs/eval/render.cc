#include "livemvs/eval/render.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "livemvs/eval/color_ramp.h"
#include "livemvs/eval/plot.h"
#include "livemvs/map/normals.h"

namespace livemvs {
namespace {

constexpr Rgb kGrey = {190, 188, 184};

float Quantile(std::vector<float> values, double q) {
  if (values.empty()) return 0;
  const auto nth = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + nth, values.end());
  return values[static_cast<std::size_t>(nth)];
}

/// Radii that close the surface: a share of the local spacing, limited where points are lonely.
std::vector<float> SplatRadii(const PointCloud& cloud, double point_size) {
  constexpr float kShare = 0.8f, kLonely = 2.5f;
  std::vector<float> radius = PointSpacing(cloud, 6);
  std::vector<float> known;
  for (float r : radius) {
    if (std::isfinite(r) && r > 0) known.push_back(r);
  }
  const float limit = kLonely * Quantile(std::move(known), 0.5);
  for (float& r : radius) r = kShare * static_cast<float>(point_size) * std::min(r, limit);
  return radius;
}

/// A number per point, its range, and how to show it.
struct Scalar {
  std::vector<float> values;
  float lo = 0, hi = 1;
  bool logarithmic = false;
  std::string label;

  double At(float value) const {
    if (!(hi > lo)) return 0.5;
    if (logarithmic) {
      return std::log(std::max(value, lo) / lo) / std::log(hi / lo);
    }
    return (value - lo) / (hi - lo);
  }
};

Scalar ScalarOf(const PointCloud& cloud, RenderColor color, const Eigen::Vector3d& up) {
  Scalar scalar;
  const Eigen::Vector3f axis = up.cast<float>();
  for (const Point& p : cloud) {
    const float value = color == RenderColor::kSigma         ? p.sigma
                        : color == RenderColor::kInlierRatio ? p.inlier_ratio
                                                             : p.position.dot(axis);
    const bool known = color != RenderColor::kSigma || value > 0;
    scalar.values.push_back(known ? value : std::numeric_limits<float>::quiet_NaN());
  }
  std::vector<float> finite;
  std::ranges::copy_if(
      scalar.values, std::back_inserter(finite), [](float v) { return std::isfinite(v); });
  scalar.lo = Quantile(finite, 0.02);
  scalar.hi = Quantile(finite, 0.98);
  scalar.logarithmic = color == RenderColor::kSigma && scalar.lo > 0;
  scalar.label = color == RenderColor::kSigma         ? "sigma"
                 : color == RenderColor::kInlierRatio ? "inlier ratio"
                                                      : "height";
  return scalar;
}

std::vector<Eigen::Vector3f> PointColors(const PointCloud& cloud,
                                         RenderColor color,
                                         const Scalar& scalar,
                                         const RenderView& view) {
  std::vector<Eigen::Vector3f> colors;
  colors.reserve(cloud.size());
  const bool colored = std::any_of(cloud.begin(), cloud.end(), [](const Point& p) {
    return p.color != Rgb{0, 0, 0};
  });
  const Eigen::Matrix3f rotation = view.cam_from_world.rotation.cast<float>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (color == RenderColor::kRgb) {
      colors.push_back(LinearFromSrgb(colored ? cloud[i].color : kGrey));
    } else if (color == RenderColor::kNormal) {
      const Eigen::Vector3f n = rotation * cloud[i].normal;
      colors.push_back(0.5f * Eigen::Vector3f(1 + n.x(), 1 - n.y(), 1 - n.z()));
    } else if (std::isnan(scalar.values[i])) {
      colors.push_back(LinearFromSrgb(kGrey));
    } else {
      colors.push_back(LinearFromSrgb(RampColor(scalar.At(scalar.values[i]))));
    }
  }
  return colors;
}

std::string WithUnit(double value, const std::string& unit) {
  return ShortNumber(value) + (unit.empty() ? "" : " " + unit);
}

void DrawScaleBar(RgbImage* image, const RenderView& view, const std::string& unit) {
  const double px_per_scene = std::abs(view.camera.fx) / view.focus_depth;
  const std::vector<double> lengths =
      RoundNumbers(0.05 * image->width() / px_per_scene, 0.2 * image->width() / px_per_scene);
  if (lengths.empty()) return;
  const double length = lengths.back() * px_per_scene;
  const double size = std::max(1.0, image->height() / 800.0);
  const double x = 28 * size, y = image->height() - 28 * size;
  Canvas canvas(*image);
  const double pen = 1.6 * size, tick = 5 * size;
  canvas.Line({x, y}, {x + length, y}, pen, kInk);
  canvas.Line({x, y - tick}, {x, y + tick}, pen, kInk);
  canvas.Line({x + length, y - tick}, {x + length, y + tick}, pen, kInk);
  canvas.Text({x + length / 2, y - 9 * size},
              WithUnit(lengths.back(), unit),
              10 * size,
              kInk,
              TextAlign::kCenter);
}

/// Rounded to two digits, as a label needs them.
double TwoDigits(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 1);
  return std::round(value / unit) * unit;
}

void DrawRamp(RgbImage* image, const Scalar& scalar, const std::string& unit) {
  const double size = std::max(1.0, image->height() / 800.0);
  const int width = static_cast<int>(14 * size), height = static_cast<int>(160 * size);
  const int x = image->width() - static_cast<int>(28 * size) - width;
  const int y = image->height() - static_cast<int>(40 * size) - height;
  Canvas canvas(*image);
  for (int row = 0; row < height; ++row) {
    canvas.Fill(x, y + row, x + width, y + row + 1, RampColor(1 - row / (height - 1.0)));
  }
  const double text = 10 * size, left = x - 8 * size;
  canvas.Text(
      {left, y + text}, WithUnit(TwoDigits(scalar.hi), unit), text, kInk, TextAlign::kRight);
  canvas.Text({left, static_cast<double>(y + height)},
              WithUnit(TwoDigits(scalar.lo), unit),
              text,
              kInk,
              TextAlign::kRight);
  canvas.Text(
      {static_cast<double>(x + width), y - 10 * size}, scalar.label, text, kInk, TextAlign::kRight);
}

}  // namespace

void CloudRenderOptions::Check() const {
  if (!(point_size > 0 && point_size <= 100)) {
    throw std::invalid_argument("point_size: must be in (0, 100]");
  }
  if (supersampling < 1 || supersampling > 4) {
    throw std::invalid_argument("supersampling: must be from 1 to 4");
  }
}

CloudRenderer::CloudRenderer(const PointCloud& cloud, const CloudRenderOptions& options)
    : options_(options) {
  options.Check();
  for (const Point& p : cloud) {
    if (p.position.allFinite()) cloud_.push_back(p);
    if (!cloud_.empty() && !cloud_.back().normal.allFinite()) cloud_.back().normal.setZero();
  }
  radius_ = SplatRadii(cloud_, options.point_size);
  if (!options.plain_normals) EstimateNormals(cloud_);
}

RgbImage CloudRenderer::Draw(const RenderView& view) const {
  const bool ramp = options_.color == RenderColor::kSigma ||
                    options_.color == RenderColor::kInlierRatio ||
                    options_.color == RenderColor::kHeight;
  const Scalar scalar = ramp ? ScalarOf(cloud_, options_.color, view.up) : Scalar{};
  const std::vector<Eigen::Vector3f> colors = PointColors(cloud_, options_.color, scalar, view);
  std::vector<Splat> splats(cloud_.size());
  for (std::size_t i = 0; i < cloud_.size(); ++i) {
    splats[i] = {cloud_[i].position, cloud_[i].normal, colors[i], radius_[i]};
  }
  const int scale = options_.supersampling;
  RgbImage image = ShadeFragments(DrawSplats(splats, view, scale),
                                  scale,
                                  std::abs(view.camera.fx) * scale,
                                  options_.color == RenderColor::kRgb);
  if (options_.scale_bar) DrawScaleBar(&image, view, options_.unit);
  if (ramp) {
    DrawRamp(&image, scalar, options_.color == RenderColor::kInlierRatio ? "" : options_.unit);
  }
  return image;
}

RgbImage RenderMesh(const TriangleMesh& mesh,
                    const RenderView& view,
                    const CloudRenderOptions& options) {
  options.Check();
  PointCloud vertices(mesh.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    vertices[i].position = mesh.vertices[i];
    if (i < mesh.colors.size()) vertices[i].color = mesh.colors[i];
  }
  const bool ramp = options.color == RenderColor::kHeight;
  const Scalar scalar = ramp ? ScalarOf(vertices, options.color, view.up) : Scalar{};
  const std::vector<Eigen::Vector3f> colors =
      PointColors(vertices, ramp ? options.color : RenderColor::kRgb, scalar, view);
  const int scale = options.supersampling;
  RgbImage image = ShadeFragments(DrawMesh(mesh, colors, view, scale),
                                  scale,
                                  std::abs(view.camera.fx) * scale,
                                  !ramp && !mesh.colors.empty());
  if (options.scale_bar) DrawScaleBar(&image, view, options.unit);
  if (ramp) DrawRamp(&image, scalar, options.unit);
  return image;
}

}  // namespace livemvs
