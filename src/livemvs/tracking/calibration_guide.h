#pragma once

#include <array>
#include <string>

#include "livemvs/tracking/calibrator.h"

namespace livemvs {

/// Says to somebody who films a board which views a calibration still lacks: slants in both
/// directions, for the focal length and the principal point, and corners in all parts of the
/// picture, for the distortion.
class CalibrationGuide {
 public:
  static constexpr int kParts = 3;          ///< The picture is divided into 3 x 3.
  static constexpr int kEnoughViews = 12;   ///< More than the least that a calibration takes.
  static constexpr int kEnoughCorners = 6;  ///< In each part of the picture, over all views.
  static constexpr double kSlant = 0.3;     ///< Sine of the angle that is a slant.

  /// @param width, height  Of the pictures [px].
  CalibrationGuide(int width, int height, const CalibratorOptions& options);

  /// Takes a view that the calibrator has kept.
  void Add(const CalibrationView& view);

  /// What to do next, for people; empty: nothing is missing.
  std::string Missing() const;

  /// The same, in view of the picture that came last.
  std::string Next(const CalibrationView& latest) const;

 private:
  std::string EmptyPart() const;

  int width_ = 0, height_ = 0;
  CalibratorOptions options_;
  int views_ = 0;
  bool slant_sideways_ = false, slant_upwards_ = false;
  std::array<int, kParts * kParts> corners_{};
};

}  // namespace livemvs
