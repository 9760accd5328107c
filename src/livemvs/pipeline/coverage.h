#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/core/image.h"
#include "livemvs/core/point.h"

namespace livemvs {

/// Where in a frame something is known already: a picture of marks for each level of its pyramid.
/// Buffers are kept between frames.
class Coverage {
 public:
  /// @param angle_deg  Points seen from directions further apart than this do not cover each other.
  explicit Coverage(float angle_deg);

  /// Clears the marks, and fits them to a frame's pyramid.
  void Reset(std::span<const ImageView<std::uint8_t>> pyramid);

  /// Marks the pixels that points project to, from where they were seen similarly. A point marks
  /// the levels on which it is not much wider than a pixel.
  /// @param points  Those of the last call, and new ones after them; see Forget().
  void MarkPoints(const PosedFrame& frame, const PointCloud& points);

  /// The points of the next call are others than those before.
  void Forget() { chunks_.clear(); }

  /// By level; 1 where something is.
  std::span<Image<std::uint8_t>> marks() { return {marks_.data(), levels_}; }

 private:
  /// A sphere about consecutive points, so that those out of view are passed over together.
  struct Chunk {
    Eigen::Vector3f center;
    float radius;
    std::size_t size;
  };

  void ExtendChunks(const PointCloud& points);

  float min_cosine_;
  std::size_t levels_ = 0;
  std::vector<Image<std::uint8_t>> marks_;
  std::vector<Chunk> chunks_;
};

}  // namespace livemvs
