#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs::viewer {

/// What is known at a place of the camera's picture.
enum class MarkKind : std::uint8_t {
  kConverging = 0,  ///< A seed at work.
  kConverged = 1,   ///< A point.
  kNoTexture = 2,   ///< Nothing that could be matched.
  kUnmatched = 3,   ///< A seed that the latest frames did not confirm, or out of view.
};

/// A mark on the picture: 8 bytes of the preview record.
struct SeedMark {
  std::uint16_t x, y;  ///< In 65535ths of the picture's width and height.
  MarkKind kind;
  std::uint8_t progress;  ///< Of a seed at work: how certain its depth is, in 255ths.
};

/// Marks of at most about `most` live seeds, evenly taken, where `frame` sees them.
std::vector<SeedMark> MarkSeeds(const SeedPool& pool,
                                const PosedFrame& frame,
                                const Options& options,
                                std::size_t most);

/// Marks of points, where the frame sees them.
void MarkPoints(std::span<const Point> points,
                const PosedFrame& frame,
                std::vector<SeedMark>* marks);

/// Marks of the blocks of the picture that have less texture than seeds need.
void MarkPlainBlocks(const ImageView<std::uint8_t>& grey,
                     float min_stddev,
                     std::vector<SeedMark>* marks);

}  // namespace livemvs::viewer
