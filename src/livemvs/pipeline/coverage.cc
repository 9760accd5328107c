#include "livemvs/pipeline/coverage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

// A point whose pixel was this many times as wide as a pixel here does not cover it.
constexpr float kCoarser = 1.5F;

// Consecutive points that are looked at together.
constexpr std::size_t kChunk = 512;

// Pixels per pixel of the next coarser level.
constexpr float kHalf = 0.5F;

// The cone about the camera's axis that holds all it sees.
float WidestAngle(const Projector& projector) {
  const Camera& c = projector.camera();
  double widest = 0;
  for (const double x : {-0.5, (c.width - 1) / 2.0, c.width - 0.5}) {
    for (const double y : {-0.5, (c.height - 1) / 2.0, c.height - 0.5}) {
      const auto ray = projector.Unproject({x, y});
      if (!ray) return static_cast<float>(M_PI);
      widest = std::max(widest, std::acos(std::clamp(ray->normalized().z(), -1.0, 1.0)));
    }
  }
  return static_cast<float>(widest);
}

// A frame's camera as points meet it.
struct Viewer {
  CameraParams<float> camera;
  CameraModel model;
  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  Eigen::Vector3f center;
  float width, height;
  float pixel_width;  // at unit depth
  float widest_angle;
  float min_cosine;

  Viewer(const PosedFrame& frame, float cosine)
      : camera(MakeCameraParams<float>(frame.camera)),
        model(frame.camera.model),
        rotation(frame.cam_from_world.rotation.cast<float>()),
        translation(frame.cam_from_world.translation.cast<float>()),
        center(frame.cam_from_world.Center().cast<float>()),
        width(static_cast<float>(frame.camera.width)),
        height(static_cast<float>(frame.camera.height)),
        pixel_width(static_cast<float>(1 / frame.camera.FocalLength())),
        widest_angle(WidestAngle(Projector(frame.camera))),
        min_cosine(cosine) {}

  // Whether anything of a sphere may be seen.
  bool Sees(const Eigen::Vector3f& point, float radius) const {
    const Eigen::Vector3f p = rotation * point + translation;
    const float distance = p.norm();
    if (distance <= radius) return true;
    return std::acos(std::clamp(p.z() / distance, -1.0F, 1.0F)) - std::asin(radius / distance) <=
           widest_angle;
  }
};

void Mark(float x, float y, Image<std::uint8_t>* marks) {
  const int u = static_cast<int>(std::floor(x + 0.5F)), v = static_cast<int>(std::floor(y + 0.5F));
  if (u < 0 || v < 0 || u >= marks->width() || v >= marks->height()) return;
  std::atomic_ref<std::uint8_t>((*marks)(u, v)).store(1, std::memory_order_relaxed);
}

template <typename Model>
void MarkPoint(const Viewer& viewer, const Point& point, std::span<Image<std::uint8_t>> marks) {
  const Eigen::Vector3f p = viewer.rotation * point.position + viewer.translation;
  if (!(p.z() > 0)) return;
  const float x = p.x() / p.z(), y = p.y() / p.z();
  if (!(x * x + y * y <= viewer.camera.r2_max)) return;
  const auto distorted = Model::Distort(viewer.camera.k, x, y);
  float u = viewer.camera.fx * distorted.x + viewer.camera.cx;
  float v = viewer.camera.fy * distorted.y + viewer.camera.cy;
  if (!(u >= 0 && v >= 0 && u < viewer.width && v < viewer.height)) return;
  // The back of an object does not cover its front: compare the directions of view.
  const float distance = p.norm();
  const float along = (viewer.center - point.position).dot(point.normal);
  if (!(along > viewer.min_cosine * distance)) return;
  // A coarse point does not stand for the finer ones that may still be found.
  float widest = kCoarser * distance * viewer.pixel_width;
  for (Image<std::uint8_t>& level : marks) {
    if (point.footprint <= widest) Mark(u, v, &level);
    u = (u + kHalf) * kHalf - kHalf;
    v = (v + kHalf) * kHalf - kHalf;
    widest *= 2;
  }
}

}  // namespace

Coverage::Coverage(float angle_deg)
    : min_cosine_(std::cos(angle_deg * static_cast<float>(M_PI / 180))) {}

void Coverage::Reset(std::span<const ImageView<std::uint8_t>> pyramid) {
  levels_ = pyramid.size();
  marks_.resize(std::max(marks_.size(), levels_));
  for (std::size_t l = 0; l < levels_; ++l) {
    Image<std::uint8_t>& marks = marks_[l];
    if (marks.width() != pyramid[l].width || marks.height() != pyramid[l].height) {
      marks = Image<std::uint8_t>(pyramid[l].width, pyramid[l].height);
    }
    std::memset(marks.Row(0), 0, static_cast<std::size_t>(marks.stride() * marks.height()));
  }
}

void Coverage::ExtendChunks(const PointCloud& points) {
  std::size_t covered = 0;
  if (!chunks_.empty() && chunks_.back().size < kChunk) chunks_.pop_back();
  covered = chunks_.size() * kChunk;
  for (; covered < points.size(); covered += kChunk) {
    const std::size_t size = std::min(kChunk, points.size() - covered);
    Eigen::AlignedBox3f box;
    for (std::size_t i = 0; i < size; ++i) box.extend(points[covered + i].position);
    chunks_.push_back({box.center(), box.diagonal().norm() / 2, size});
  }
}

void Coverage::MarkPoints(const PosedFrame& frame, const PointCloud& points) {
  ExtendChunks(points);
  const Viewer viewer(frame, min_cosine_);
  VisitModel(viewer.model, [&](auto model) {
    ParallelForRange(0, chunks_.size(), 4, [&](std::size_t first, std::size_t last) {
      for (std::size_t c = first; c < last; ++c) {
        if (!viewer.Sees(chunks_[c].center, chunks_[c].radius)) continue;
        for (std::size_t i = 0; i < chunks_[c].size; ++i) {
          MarkPoint<decltype(model)>(viewer, points[c * kChunk + i], marks());
        }
      }
    });
  });
}

}  // namespace livemvs
