#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/image.h"

namespace livemvs {

/// An 8-bit colour picture, (height, width), red green blue.
using RgbImage = Image<Rgb>;

/// Of text, axes and scales.
inline constexpr Rgb kInk = {45, 48, 54};

/// A picture of one colour.
RgbImage MakeRgbImage(int width, int height, Rgb color);

/// How a text is placed about its position.
enum class TextAlign { kLeft, kCenter, kRight };

/// Draws anti-aliased lines and text on a picture. Coordinates are in pixels; pixel centres are
/// integers; what lies outside of the picture is cut away.
class Canvas {
 public:
  explicit Canvas(RgbImage& image) : image_(image) {}

  void Line(Eigen::Vector2d a, Eigen::Vector2d b, double width, Rgb color);

  /// A line through all points, covered once where its pieces overlap.
  void Polyline(const std::vector<Eigen::Vector2d>& points, double width, Rgb color);

  /// Fills [x0, x1) x [y0, y1), `opacity` in [0, 1].
  void Fill(int x0, int y0, int x1, int y1, Rgb color, double opacity = 1);

  /// Text on the baseline through `at`, capitals `height` pixels high. Printable ASCII; anything
  /// else is drawn as a box.
  void Text(Eigen::Vector2d at,
            std::string_view text,
            double height,
            Rgb color,
            TextAlign align = TextAlign::kLeft);

  /// The same, turned so that it reads upwards.
  void TextUpwards(Eigen::Vector2d at,
                   std::string_view text,
                   double height,
                   Rgb color,
                   TextAlign align = TextAlign::kLeft);

  /// Length of the text. [px]
  static double TextWidth(std::string_view text, double height);

 private:
  void DrawText(Eigen::Vector2d at,
                Eigen::Vector2d along,
                std::string_view text,
                double height,
                Rgb color,
                TextAlign align);
  void Blend(int x, int y, Rgb color, double opacity);

  RgbImage& image_;
};

}  // namespace livemvs
