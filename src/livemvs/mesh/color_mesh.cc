#include "livemvs/mesh/color_mesh.h"

#include <algorithm>
#include <cmath>

#include "livemvs/map/point_index.h"
#include "livemvs/mesh/facing.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

constexpr double kBorderPx = 2;       ///< Not so close to a picture's edge.
constexpr float kLeastFacing = 0.2F;  ///< Cosine between normal and view.

std::uint8_t ToByte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

MeshColorizer::MeshColorizer(const TriangleMesh& mesh, double thickness)
    : mesh_(mesh),
      surface_(mesh),
      normals_(VertexNormals(mesh)),
      thickness_(static_cast<float>(thickness)),
      views_(mesh.vertices.size()) {}

void MeshColorizer::AddFrame(const PosedFrame& frame) {
  const SurfaceViewer viewer({frame.camera, frame.cam_from_world}, kBorderPx);
  ParallelForRange(0, views_.size(), 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto seen =
          viewer.See(mesh_.vertices[i], normals_[i], kLeastFacing, surface_, thickness_);
      if (!seen) continue;
      views_[i].Add(seen->facing * seen->facing / (seen->length * seen->length),
                    frame.picture->ColorAt(static_cast<int>(std::lround(seen->pixel.x())),
                                           static_cast<int>(std::lround(seen->pixel.y()))));
    }
  });
}

void MeshColorizer::Views::Add(float weight_of_new, const Rgb& color_of_new) {
  std::size_t at = count;
  if (count == kMostViews) {
    at = static_cast<std::size_t>(std::ranges::min_element(weight) - weight.begin());
    if (weight[at] >= weight_of_new) return;
  } else {
    ++count;
  }
  weight[at] = weight_of_new;
  color[at] = color_of_new;
}

/// The weighted mean of the views near the median, channel by channel.
Rgb MeshColorizer::Views::Blend() const {
  Rgb result{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::array<std::uint8_t, kMostViews> values{};
    for (std::size_t k = 0; k < count; ++k) values[k] = color[k][c];
    const auto middle = values.begin() + count / 2;
    std::nth_element(values.begin(), middle, values.begin() + count);
    constexpr int kNear = 24;
    double sum = 0, weights = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (std::abs(int{color[k][c]} - int{*middle}) > kNear) continue;
      sum += double{weight[k]} * color[k][c];
      weights += double{weight[k]};
    }
    result[c] = weights > 0 ? ToByte(sum / weights) : *middle;
  }
  return result;
}

std::size_t MeshColorizer::seen() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(views_, [](const Views& v) { return v.count > 0; }));
}

std::vector<Rgb> MeshColorizer::Take(std::vector<Rgb> otherwise) const {
  ParallelForRange(0, views_.size(), 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (views_[i].count > 0) otherwise[i] = views_[i].Blend();
    }
  });
  return otherwise;
}

std::vector<Rgb> ColorsOfPoints(const TriangleMesh& mesh, const SightLines& points) {
  constexpr int kNeighbors = 6;
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(points.lines.size());
  for (const SightLine& l : points.lines) positions.push_back(l.position);
  const PointIndex index(std::move(positions));
  std::vector<Rgb> colors(mesh.vertices.size());
  ParallelForRange(0, colors.size(), 256, [&](std::size_t first, std::size_t last) {
    std::vector<PointIndex::Neighbor> near;
    for (std::size_t i = first; i < last; ++i) {
      index.Nearest(mesh.vertices[i], kNeighbors, &near);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double weights = 0;
      for (const PointIndex::Neighbor& n : near) {
        const double weight = 1 / (double{n.distance2} + 0.25 * points.spacing * points.spacing);
        const Rgb& c = points.colors[n.index];
        sum += weight * Eigen::Vector3d(c[0], c[1], c[2]);
        weights += weight;
      }
      if (weights > 0) sum /= weights;
      colors[i] = {ToByte(sum[0]), ToByte(sum[1]), ToByte(sum[2])};
    }
  });
  return colors;
}

double SharpnessOf(const Picture& picture) {
  constexpr int kStep = 2;
  double sum = 0;
  std::int64_t count = 0;
  for (int y = 1; y + 1 < picture.height(); y += kStep) {
    for (int x = 1; x + 1 < picture.width(); x += kStep) {
      const int laplacian = 4 * picture.grey(x, y) - picture.grey(x - 1, y) -
                            picture.grey(x + 1, y) - picture.grey(x, y - 1) -
                            picture.grey(x, y + 1);
      sum += static_cast<double>(laplacian) * laplacian;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace livemvs
