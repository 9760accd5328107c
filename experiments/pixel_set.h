#pragma once

#include <functional>
#include <vector>

#include "livemvs/synth/scene.h"
#include "photo_set.h"
#include "pixel_sensor.h"

namespace livemvs::experiments {

/// Of rendered pictures [grey levels].
inline constexpr double kNoise = 2;

/// A scene in pictures, and some of its pixels as depth sensors.
struct PixelSet {
  SyntheticScene scene;
  PhotoSet photos;
  std::vector<PixelSensor> sensors;

  /// The first sensor of which `fits` is true, else the first of all.
  const PixelSensor& Find(const std::function<bool(const PixelSensor&)>& fits) const;
};

/// The carved temple front in 312 views from a hemisphere, in place of Middlebury's fullTemple.
/// Pixels are drawn at random from all views and look at the 60 nearest others, nearest first; a
/// view's measurement is its largest local maximum.
/// @param quick  Few views, small pictures, few pixels.
PixelSet MakeRelief(bool quick);

/// A still life, filmed from a hand that moves through 40 degrees in four seconds. Pixels are drawn
/// at random from the first frame and look at all others in order; a frame's measurement is its
/// largest local maximum, as in Algorithm 1.
PixelSet MakeVideo(bool quick);

/// For tables: scene units are metres.
inline constexpr double kMillimetres = 1000;

/// Prints a line about the progress of something to the standard error stream, over itself.
void ShowProgress(const char* what, int done, int all);

}  // namespace livemvs::experiments
