#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "livemvs/core/image.h"
#include "livemvs/core/point.h"
#include "livemvs/io/dataset.h"
#include "livemvs/reference/ncc_curve.h"
#include "livemvs/synth/scene.h"
#include "livemvs/synth/sequence.h"

namespace livemvs::experiments {

/// Posed grey pictures of something inside a box. [scene]
struct PhotoSet {
  std::vector<std::unique_ptr<Image<std::uint8_t>>> images;  ///< What the views look into.
  std::vector<reference::PosedView> views;
  Box box;  ///< [Z_min, Z_max] of a ray is its stretch in here.
};

/// Called with the number of pictures done and of all.
using Progress = std::function<void(int, int)>;

/// Renders all frames of a sequence.
PhotoSet RenderPhotos(const SyntheticScene& scene,
                      const SequenceOptions& sequence,
                      const Progress& progress);

/// Reads all pictures of a data set that brings a box along. @throws Error
PhotoSet ReadPhotos(Dataset* dataset);

/// The `count` views nearest to a view, nearest first, of those whose pictures are turned against
/// it by less than 45 degrees: unwarped patches can match in no others.
std::vector<int> NearestViews(const PhotoSet& photos, int view, int count);

}  // namespace livemvs::experiments
