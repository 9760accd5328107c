#pragma once

#include <functional>
#include <vector>

#include "livemvs/synth/scene.h"
#include "photo_set.h"
#include "pixel_sensor.h"

namespace livemvs::experiments {

/// The carved temple front in 312 views from a hemisphere, in place of Middlebury's fullTemple, and
/// pixels of it that were drawn at random with their measurements in the 60 nearest views.
struct Relief {
  SyntheticScene scene;
  PhotoSet photos;
  std::vector<PixelSensor> sensors;

  /// The first sensor of which `fits` is true, else the first of all.
  const PixelSensor& Find(const std::function<bool(const PixelSensor&)>& fits) const;
};

/// @param quick  Few views, small pictures, few pixels.
Relief MakeRelief(bool quick);

/// For tables: scene units are metres.
inline constexpr double kMillimetres = 1000;

/// Prints a line about the progress of something to the standard error stream, over itself.
void ShowProgress(const char* what, int done, int all);

}  // namespace livemvs::experiments
