#pragma once

#include <cstdint>

#include "livemvs/backend/backend.h"
#include "livemvs/backend/mark_image.h"
#include "livemvs/backend/seed_columns.h"

namespace livemvs {

/// The current picture at one level of its pyramid, as the samplers take it.
struct CurrentImage {
  ImageView<std::uint8_t> grey;
  ImageView<std::uint16_t> pairs;  ///< RowPairs of it; needed where sampling grids are warped.
};

/// What the update of a run of seeds needs beside the seeds.
struct UpdateJob {
  const Options* options;
  const OutlierRule* is_outlier;
  SeedColumns seeds;
  const SeedGroup* group;
  CameraModel model;
  CurrentImage image;
  bool warp;  ///< Turn and scale the sampling grid with the relative pose.
};

/// What marking the places of a run of seeds needs.
struct MarkJob {
  DepthCoordinate coordinate;
  SeedColumns seeds;
  const SeedGroup* group;
  CameraModel model;
  MarkImage marks;  ///< Of the group's level of the pyramid.
};

}  // namespace livemvs
