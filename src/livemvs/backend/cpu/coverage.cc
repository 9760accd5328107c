#include "livemvs/backend/cpu/coverage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "livemvs/backend/cover_rule.h"
#include "livemvs/parallel/parallel_for.h"

namespace livemvs {
namespace {

// Consecutive points that are looked at together.
constexpr std::size_t kChunk = 512;

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

// Whether anything of a sphere may be seen. Rounding hides nothing.
bool Sees(const CoverView& view, float widest_angle, const Eigen::Vector3f& center, float radius) {
  constexpr float kRounding = 1e-4F;  // [rad]
  using RowMajor = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  const Eigen::Vector3f p = Eigen::Map<const RowMajor>(view.rotation) * center +
                            Eigen::Map<const Eigen::Vector3f>(view.translation);
  const float distance = p.norm();
  if (distance <= radius) return true;
  return std::acos(std::clamp(p.z() / distance, -1.0F, 1.0F)) - std::asin(radius / distance) <=
         widest_angle + kRounding;
}

}  // namespace

void Coverage::Reset(std::span<const ImageView<std::uint8_t>> pyramid) {
  pictures_.resize(std::max(pictures_.size(), pyramid.size()));
  marks_.clear();
  for (std::size_t l = 0; l < pyramid.size(); ++l) {
    Image<std::uint8_t>& picture = pictures_[l];
    if (picture.width() != pyramid[l].width || picture.height() != pyramid[l].height) {
      picture = Image<std::uint8_t>(pyramid[l].width, pyramid[l].height);
    }
    std::memset(picture.Row(0), 0, static_cast<std::size_t>(picture.stride() * picture.height()));
    marks_.push_back({picture.Row(0), picture.width(), picture.height(), picture.stride()});
  }
}

void Coverage::ExtendChunks(std::span<const Point> points) {
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

void Coverage::MarkPoints(const PosedCamera& frame, std::span<const Point> points) {
  ExtendChunks(points);
  const CoverView view = MakeCoverView(frame, angle_deg_);
  const float widest_angle = WidestAngle(Projector(frame.camera));
  const int levels = static_cast<int>(marks_.size());
  VisitModel(frame.camera.model, [&](auto model) {
    ParallelForRange(0, chunks_.size(), 4, [&](std::size_t first, std::size_t last) {
      for (std::size_t c = first; c < last; ++c) {
        if (!Sees(view, widest_angle, chunks_[c].center, chunks_[c].radius)) continue;
        for (std::size_t i = 0; i < chunks_[c].size; ++i) {
          const CoverPoint point = CoverPointOf(points[c * kChunk + i]);
          MarkPoint<decltype(model)>(view, point, marks_.data(), levels);
        }
      }
    });
  });
}

}  // namespace livemvs
