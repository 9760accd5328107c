#include "livemvs/eval/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace livemvs {
namespace {

constexpr Rgb kPaper = {255, 255, 255};
constexpr Rgb kGrid = {226, 229, 233};

/// Maps the values of the axes to the pixels of the plot's frame.
class Axes {
 public:
  Axes(const CurvePlot& plot, int width, int height)
      : log_min_(std::log(plot.x_min)),
        log_max_(std::log(plot.x_max)),
        left(80),
        right(width - 30),
        top(56),
        bottom(height - 70) {}

  Eigen::Vector2d At(double x, double y) const {
    const double u = (std::log(x) - log_min_) / (log_max_ - log_min_);
    return {left + u * (right - left), bottom - y * (bottom - top)};
  }

 private:
  double log_min_, log_max_;

 public:
  int left, right, top, bottom;
};

void DrawFrame(Canvas& canvas, const CurvePlot& plot, const Axes& axes) {
  constexpr double kTextHeight = 11;
  for (int percent = 0; percent <= 100; percent += 10) {
    const Eigen::Vector2d left = axes.At(plot.x_min, percent / 100.0);
    canvas.Line(left, axes.At(plot.x_max, percent / 100.0), 1, kGrid);
    if (percent % 20 == 0) {
      canvas.Text(left + Eigen::Vector2d(-10, kTextHeight / 2),
                  std::to_string(percent) + "%",
                  kTextHeight,
                  kInk,
                  TextAlign::kRight);
    }
  }
  for (double x : RoundNumbers(plot.x_min, plot.x_max)) {
    const Eigen::Vector2d bottom = axes.At(x, 0);
    canvas.Line(bottom, axes.At(x, 1), 1, kGrid);
    canvas.Line(bottom, bottom + Eigen::Vector2d(0, 5), 1.2, kInk);
    canvas.Text(bottom + Eigen::Vector2d(0, 12 + kTextHeight),
                ShortNumber(x),
                kTextHeight,
                kInk,
                TextAlign::kCenter);
  }
  canvas.Polyline(
      {axes.At(plot.x_min, 1), axes.At(plot.x_min, 0), axes.At(plot.x_max, 0)}, 1.5, kInk);
  const double middle_x = (axes.left + axes.right) / 2.0;
  const double middle_y = (axes.top + axes.bottom) / 2.0;
  canvas.Text({middle_x, axes.bottom + 54.0}, plot.x_label, 12, kInk, TextAlign::kCenter);
  canvas.TextUpwards({22, middle_y}, plot.y_label, 12, kInk, TextAlign::kCenter);
  canvas.Text({static_cast<double>(axes.left), 34}, plot.title, 14, kInk);
}

void DrawLegend(Canvas& canvas, const CurvePlot& plot, const Axes& axes) {
  constexpr double kTextHeight = 11, kLine = 24, kMargin = 14, kSample = 34;
  double text_width = 0;
  for (const CurvePlot::Curve& curve : plot.curves) {
    text_width = std::max(text_width, Canvas::TextWidth(curve.label, kTextHeight));
  }
  const double width = kMargin * 2 + kSample + 10 + text_width;
  const double height = kMargin + kLine * static_cast<double>(plot.curves.size());
  const double x = axes.right - width - 12, y = axes.bottom - height - 12;
  canvas.Fill(static_cast<int>(x),
              static_cast<int>(y),
              static_cast<int>(x + width),
              static_cast<int>(y + height),
              kPaper,
              0.9);
  double baseline = y + kMargin + kTextHeight;
  for (const CurvePlot::Curve& curve : plot.curves) {
    const double middle = baseline - kTextHeight / 2;
    canvas.Line({x + kMargin, middle}, {x + kMargin + kSample, middle}, 2.5, curve.color);
    canvas.Text({x + kMargin + kSample + 10, baseline}, curve.label, kTextHeight, kInk);
    baseline += kLine;
  }
}

}  // namespace

RgbImage CurvePlot::Draw(int width, int height) const {
  if (!(x_min > 0 && x_min < x_max && std::isfinite(x_max))) {
    throw std::invalid_argument("CurvePlot: the x axis must have 0 < x_min < x_max");
  }
  if (width < 320 || height < 240) {
    throw std::invalid_argument("CurvePlot: the picture must have at least 320 x 240 pixels");
  }
  RgbImage image = MakeRgbImage(width, height, kPaper);
  Canvas canvas(image);
  const Axes axes(*this, width, height);
  DrawFrame(canvas, *this, axes);
  for (const Curve& curve : curves) {
    std::vector<Eigen::Vector2d> line;
    for (const Eigen::Vector2d& p : curve.points) {
      if (p.x() >= x_min && p.x() <= x_max && std::isfinite(p.y())) {
        line.push_back(axes.At(p.x(), std::clamp(p.y(), 0.0, 1.0)));
      }
    }
    canvas.Polyline(line, 2.5, curve.color);
  }
  DrawLegend(canvas, *this, axes);
  return image;
}

std::vector<double> RoundNumbers(double lo, double hi) {
  std::vector<double> numbers;
  if (!(lo > 0 && lo <= hi && std::isfinite(hi))) return numbers;
  const int first = static_cast<int>(std::floor(std::log10(lo)));
  const int last = static_cast<int>(std::ceil(std::log10(hi)));
  for (int exponent = first; exponent <= last; ++exponent) {
    for (double mantissa : {1.0, 2.0, 5.0}) {
      const double x = mantissa * std::pow(10.0, exponent);
      if (x >= lo * (1 - 1e-9) && x <= hi * (1 + 1e-9)) numbers.push_back(x);
    }
  }
  return numbers;
}

std::string ShortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

}  // namespace livemvs
