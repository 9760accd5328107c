#include "livemvs/eval/canvas.h"

#include <algorithm>
#include <cmath>

#include "livemvs/eval/stroke_font.h"

namespace livemvs {
namespace {

double SegmentDistance(const Eigen::Vector2d& p,
                       const Eigen::Vector2d& a,
                       const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

}  // namespace

RgbImage MakeRgbImage(int width, int height, Rgb color) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y) std::fill_n(image.Row(y), width, color);
  return image;
}

void Canvas::Blend(int x, int y, Rgb color, double opacity) {
  Rgb& pixel = image_(x, y);
  for (std::size_t c = 0; c < 3; ++c) {
    pixel[c] = static_cast<std::uint8_t>(
        std::lround(pixel[c] + std::clamp(opacity, 0.0, 1.0) * (color[c] - pixel[c])));
  }
}

void Canvas::Line(Eigen::Vector2d a, Eigen::Vector2d b, double width, Rgb color) {
  Polyline({a, b}, width, color);
}

void Canvas::Polyline(const std::vector<Eigen::Vector2d>& points, double width, Rgb color) {
  if (points.size() < 2) return;
  const double reach = width / 2 + 1;
  Eigen::Vector2d lo = points[0], hi = points[0];
  for (const Eigen::Vector2d& p : points) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  if (!lo.allFinite() || !hi.allFinite()) return;
  const auto bound = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  const int x0 = bound(std::floor(lo.x() - reach), image_.width());
  const int y0 = bound(std::floor(lo.y() - reach), image_.height());
  const int x1 = bound(std::ceil(hi.x() + reach) + 1, image_.width());
  const int y1 = bound(std::ceil(hi.y() + reach) + 1, image_.height());
  if (x0 >= x1 || y0 >= y1) return;

  // Coverage of the union: per pixel the greatest of the pieces.
  std::vector<float> cover(static_cast<std::size_t>(x1 - x0) * (y1 - y0), 0.0f);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d &a = points[i], &b = points[i + 1];
    const int sx0 = std::max(x0, bound(std::floor(std::min(a.x(), b.x()) - reach), x1));
    const int sx1 = bound(std::ceil(std::max(a.x(), b.x()) + reach) + 1, x1);
    const int sy0 = std::max(y0, bound(std::floor(std::min(a.y(), b.y()) - reach), y1));
    const int sy1 = bound(std::ceil(std::max(a.y(), b.y()) + reach) + 1, y1);
    for (int y = sy0; y < sy1; ++y) {
      for (int x = sx0; x < sx1; ++x) {
        const double d = SegmentDistance({x, y}, a, b);
        float& c = cover[static_cast<std::size_t>(y - y0) * (x1 - x0) + (x - x0)];
        c = std::max(c, static_cast<float>(std::clamp(width / 2 + 0.5 - d, 0.0, 1.0)));
      }
    }
  }
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const float c = cover[static_cast<std::size_t>(y - y0) * (x1 - x0) + (x - x0)];
      if (c > 0) Blend(x, y, color, c * std::min(width, 1.0));
    }
  }
}

void Canvas::Fill(int x0, int y0, int x1, int y1, Rgb color, double opacity) {
  for (int y = std::max(y0, 0); y < std::min(y1, image_.height()); ++y) {
    for (int x = std::max(x0, 0); x < std::min(x1, image_.width()); ++x)
      Blend(x, y, color, opacity);
  }
}

void Canvas::Text(
    Eigen::Vector2d at, std::string_view text, double height, Rgb color, TextAlign align) {
  DrawText(at, {1, 0}, text, height, color, align);
}

void Canvas::TextUpwards(
    Eigen::Vector2d at, std::string_view text, double height, Rgb color, TextAlign align) {
  DrawText(at, {0, -1}, text, height, color, align);
}

double Canvas::TextWidth(std::string_view text, double height) {
  double width = 0;
  for (char c : text) width += GlyphOf(c).advance;
  return width * height / kCapHeight;
}

void Canvas::DrawText(Eigen::Vector2d at,
                      Eigen::Vector2d along,
                      std::string_view text,
                      double height,
                      Rgb color,
                      TextAlign align) {
  const double scale = height / kCapHeight;
  const Eigen::Vector2d up(along.y(), -along.x());
  const double width = TextWidth(text, height);
  if (align == TextAlign::kCenter) at -= along * width / 2;
  if (align == TextAlign::kRight) at -= along * width;
  const double pen = std::max(1.0, height / 8);
  for (char c : text) {
    const Glyph glyph = GlyphOf(c);
    for (const auto& stroke : glyph.strokes) {
      std::vector<Eigen::Vector2d> points;
      points.reserve(stroke.size());
      for (const Eigen::Vector2d& p : stroke) {
        points.push_back(at + scale * (p.x() * along + p.y() * up));
      }
      Polyline(points, pen, color);
    }
    at += along * glyph.advance * scale;
  }
}

}  // namespace livemvs
