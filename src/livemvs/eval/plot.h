#pragma once

#include <string>
#include <vector>

#include "livemvs/eval/canvas.h"

namespace livemvs {

/// A picture of curves over a logarithmic x axis and a y axis from 0 to 100 %.
struct CurvePlot {
  struct Curve {
    std::string label;
    Rgb color{};
    std::vector<Eigen::Vector2d> points;  ///< x in the unit of the axis, y in [0, 1].
  };

  std::string title;
  std::string x_label;
  std::string y_label;
  double x_min = 0.1;  ///< > 0
  double x_max = 10;   ///< > x_min
  std::vector<Curve> curves;

  /// @throws std::invalid_argument where the axis is empty or the picture smaller than 320 x 240.
  RgbImage Draw(int width = 960, int height = 640) const;
};

/// The numbers 1, 2, 5 times powers of ten in [lo, hi]. Nothing unless 0 < lo <= hi < infinity.
std::vector<double> RoundNumbers(double lo, double hi);

/// As short as it goes: "0.5", "20", "1e-05".
std::string ShortNumber(double value);

}  // namespace livemvs
