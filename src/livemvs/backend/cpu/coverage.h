#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "livemvs/backend/mark_image.h"
#include "livemvs/core/image.h"
#include "livemvs/core/point.h"
#include "livemvs/core/posed_camera.h"

namespace livemvs {

/// Where in a frame something is known already: a picture of marks for each level of its pyramid.
/// Buffers are kept between frames.
class Coverage {
 public:
  /// @param angle_deg  Points seen from directions further apart than this do not cover each other.
  explicit Coverage(float angle_deg) : angle_deg_(angle_deg) {}

  /// Clears the marks, and fits them to a frame's pyramid.
  void Reset(std::span<const ImageView<std::uint8_t>> pyramid);

  /// Marks what points cover; see MarkPoint().
  /// @param points  Those of the last call, and new ones after them; see Forget().
  void MarkPoints(const PosedCamera& frame, std::span<const Point> points);

  /// The points of the next call are others than those before.
  void Forget() { chunks_.clear(); }

  /// By level.
  std::span<const MarkImage> marks() const { return marks_; }

 private:
  /// A sphere about consecutive points, so that those out of view are passed over together.
  struct Chunk {
    Eigen::Vector3f center;
    float radius;
    std::size_t size;
  };

  void ExtendChunks(std::span<const Point> points);

  float angle_deg_;
  std::vector<Image<std::uint8_t>> pictures_;
  std::vector<MarkImage> marks_;  // of the first of them
  std::vector<Chunk> chunks_;
};

}  // namespace livemvs
