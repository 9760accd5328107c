#include "viewer/seed_marks.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace livemvs::viewer {
namespace {

// Side of the blocks whose texture is judged, as a share of the picture's width.
constexpr int kBlocksAcross = 32;

// A seed has told enough to be judged after so many frames.
constexpr int kYoung = 8;

std::optional<SeedMark> MarkAt(const Projector& projector,
                               const Eigen::Vector3d& point_in_cam,
                               MarkKind kind) {
  const auto pixel = projector.Project(point_in_cam);
  const Camera& camera = projector.camera();
  if (!pixel || !camera.Contains(*pixel)) return std::nullopt;
  return SeedMark{static_cast<std::uint16_t>(65535 * pixel->x() / camera.width),
                  static_cast<std::uint16_t>(65535 * pixel->y() / camera.height),
                  kind,
                  0};
}

// From nothing known to the threshold of convergence, on a logarithmic scale.
std::uint8_t Progress(float sigma, float range, float goal) {
  if (!(sigma > 0) || !(range > goal)) return 0;
  const float share = std::log(range / sigma) / std::log(range / goal);
  return static_cast<std::uint8_t>(255 * std::clamp(share, 0.0F, 1.0F));
}

}  // namespace

std::vector<SeedMark> MarkSeeds(const SeedPool& pool,
                                const PosedFrame& frame,
                                const Options& options,
                                std::size_t most) {
  std::vector<SeedMark> marks;
  const Projector projector(frame.camera);
  const std::size_t step = pool.size() / std::max<std::size_t>(most, 1) + 1;
  pool.ForEachAlive(step, [&](const ReferenceFrame& reference, const SeedState& seed) {
    const Rigid3d cur_from_ref = frame.cam_from_world * reference.cam_from_world.Inverse();
    const auto pixel_width = static_cast<float>(1 / reference.camera.FocalLength());
    const DepthEstimate<float> z =
        DepthOf<float>(options.coordinate, seed.interval, seed.posterior.mu, seed.posterior.sigma2);
    if (!(z.depth > 0) || !std::isfinite(z.depth)) return;
    const Eigen::Vector3d bearing = Eigen::Vector3d(seed.bearing_x, seed.bearing_y, 1).normalized();
    const SeedCounts& counts = seed.counts;
    const bool lost = counts.unseen > 0 || (counts.age > kYoung && counts.views < kYoung / 4);
    auto mark = MarkAt(projector,
                       cur_from_ref * (bearing * static_cast<double>(z.depth)),
                       lost ? MarkKind::kUnmatched : MarkKind::kConverging);
    if (!mark) return;
    mark->progress = Progress(z.sigma,
                              DepthRange(options.coordinate, seed.interval),
                              options.epsilon_px * pixel_width * z.depth);
    marks.push_back(*mark);
  });
  return marks;
}

void MarkPoints(std::span<const Point> points,
                const PosedFrame& frame,
                std::vector<SeedMark>* marks) {
  const Projector projector(frame.camera);
  for (const Point& point : points) {
    const auto mark = MarkAt(
        projector, frame.cam_from_world * point.position.cast<double>(), MarkKind::kConverged);
    if (mark) marks->push_back(*mark);
  }
}

void MarkPlainBlocks(const ImageView<std::uint8_t>& grey,
                     float min_stddev,
                     std::vector<SeedMark>* marks) {
  const int side = std::max(4, grey.width / kBlocksAcross);
  for (int y = 0; y + side <= grey.height; y += side) {
    for (int x = 0; x + side <= grey.width; x += side) {
      std::int64_t sum = 0, squares = 0, count = 0;
      for (int v = y; v < y + side; v += 2) {
        for (int u = x; u < x + side; u += 2) {
          const int value = grey(u, v);
          sum += value;
          squares += value * value;
          ++count;
        }
      }
      const double mean = static_cast<double>(sum) / static_cast<double>(count);
      const double variance =
          static_cast<double>(squares) / static_cast<double>(count) - mean * mean;
      if (variance >= static_cast<double>(min_stddev * min_stddev)) continue;
      marks->push_back({static_cast<std::uint16_t>(65535 * (x + side / 2) / grey.width),
                        static_cast<std::uint16_t>(65535 * (y + side / 2) / grey.height),
                        MarkKind::kNoTexture,
                        0});
    }
  }
}

}  // namespace livemvs::viewer
