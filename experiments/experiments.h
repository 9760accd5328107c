#pragma once

#include <filesystem>

#include "pixel_set.h"

/// The experiments of [VH11], each writing its tables into a folder; scripts/reproduce_paper draws
/// them. Lengths in the tables are millimetres.
namespace livemvs::experiments {

/// Bins of the dense posterior in depth and in the inlier ratio, [VH11] Sec. 3.1.
inline constexpr int kZBins = 500, kPiBins = 100;

/// Both counts of the prior of the inlier ratio, [VH11] Sec. 4.2.
inline constexpr double kPrior = 10;

struct Settings {
  std::filesystem::path tables;  ///< Folder of the tables.
  std::filesystem::path maps;    ///< Folder of tables that are too large to keep.
  std::filesystem::path temple;  ///< Middlebury's templeRing; empty: not there.
  bool quick = false;            ///< Tiny sizes: shows that everything works, and nothing more.
};

/// Fig. 2: NCC over depth, and the local maxima of many neighbours.
void NccCurves(const Settings& settings, const PixelSet& relief);

/// Fig. 3: dense against parametric posterior, a success and a failure.
void Posteriors(const Settings& settings, const PixelSet& video);

/// Fig. 4: the parametric posterior over the updates.
void Evolution(const Settings& settings, const PixelSet& video);

/// Fig. 5: sensors that see texture, no texture, and an occlusion.
void SensorKinds(const Settings& settings, const PixelSet& video);

/// Table 1: accuracy of histogram voting and of the posterior.
void Table1(const Settings& settings, const PixelSet& relief);

/// Sec. 3.1's "EM was trapped in a local optimum for a significant percentage of cases".
void LocalOptima(const Settings& settings, const PixelSet& relief);

/// Fig. 7: accuracy and completeness for 600 and for 30 frames of a video of a house.
void House(const Settings& settings);

/// The update's textbook form in float, over the posterior's width.
void FloatUpdates(const Settings& settings);

}  // namespace livemvs::experiments
