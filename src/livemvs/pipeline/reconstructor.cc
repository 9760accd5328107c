#include "livemvs/pipeline/reconstructor.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "livemvs/pipeline/seed_groups.h"

namespace livemvs {
namespace {

// Differs from [VH11] Algorithm 1, which fills every free slot in every frame: new seeds are
// planted once this share of the pool is free, because planting looks at the whole picture.
constexpr double kFreeShare = 0.02;

class StageTimer {
 public:
  explicit StageTimer(double* seconds) : seconds_(seconds), start_(Clock::now()) {}
  ~StageTimer() { *seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  double* seconds_;
  Clock::time_point start_;
};

const Options& Checked(const Options& options) {
  options.Check();
  return options;
}

// The first seed from i on that is not simply alive, or `end`.
std::size_t SkipAlive(const Fate* fate, std::size_t i, std::size_t end) {
  static_assert(sizeof(Fate) == 1 && static_cast<int>(Fate::kAlive) == 0);
  std::uint64_t eight = 0;
  while (i + sizeof eight <= end) {
    std::memcpy(&eight, fate + i, sizeof eight);
    if (eight != 0) break;
    i += sizeof eight;
  }
  while (i < end && fate[i] == Fate::kAlive) ++i;
  return i;
}

}  // namespace

struct Reconstructor::Workers {
  explicit Workers(int threads) : arena(threads > 0 ? threads : tbb::task_arena::automatic) {}
  tbb::task_arena arena;
};

Reconstructor::~Reconstructor() = default;

Reconstructor::Reconstructor(const Options& options, const SceneRange& range)
    : options_(Checked(options)),
      workers_(std::make_unique<Workers>(options.threads)),
      pool_(static_cast<std::size_t>(options.max_seeds)),
      spawner_(options, range),
      backend_(MakeCpuBackend(options)) {}

std::span<const Point> Reconstructor::AddFrame(const PosedFrame& frame) {
  if (frame.picture == nullptr) throw std::invalid_argument(frame.name + ": has no picture");
  if (!frame.cam_from_world.rotation.allFinite() || !frame.cam_from_world.translation.allFinite()) {
    throw std::invalid_argument(frame.name + ": the pose is not finite");
  }
  frame.camera.Check();
  if (frame.picture->width() != frame.camera.width ||
      frame.picture->height() != frame.camera.height) {
    throw std::invalid_argument(frame.name + ": the picture is not of the size of its camera");
  }
  const std::size_t points_before = points_.size();
  workers_->arena.execute([&] { RunAlgorithm(frame); });
  return std::span<const Point>(points_).subspan(points_before);
}

void Reconstructor::RunAlgorithm(const PosedFrame& frame) {
  last_frame_ = frame.index;
  pyramid_.Build(frame.picture->grey, options_.levels);
  // [VH11] Algorithm 1. Steps 2 to 4 come first: a seed tells nothing in the frame it was born in.
  UpdateSeeds(frame);   // step 2: project, match, fuse
  CollectSeeds(frame);  // steps 3 and 4: remove outliers, convert what has converged
  SpawnSeeds(frame);    // step 1: if S < M, M - S new seeds
  ++statistics_.frames;
}

void Reconstructor::UpdateSeeds(const PosedFrame& frame) {
  const StageTimer timer(&statistics_.update_seconds);
  const std::vector<SeedGroup> groups =
      MakeGroups(pool_.references(), frame.camera, frame.cam_from_world, pyramid_.levels().size());
  statistics_.updates +=
      backend_->Update(pool_.columns(), groups, frame.camera.model, pyramid_.levels());
}

void Reconstructor::CollectSeeds(const PosedFrame& frame) {
  const StageTimer timer(&statistics_.collect_seconds);
  const Projector projector(frame.camera);
  for (const ReferenceFrame& reference : pool_.references()) {
    for (std::size_t i = reference.begin; i < reference.end; ++i) {
      i = SkipAlive(pool_.columns().fate, i, reference.end);
      if (i == reference.end) break;
      switch (pool_.columns().fate[i]) {
        case Fate::kAlive:
        case Fate::kRemoved:
          continue;
        case Fate::kConverged:
          Convert(reference, i, frame, projector);
          break;
        case Fate::kOutlier:
          ++statistics_.rejected_outlier;
          break;
        case Fate::kAged:
          ++statistics_.rejected_aged;
          break;
        case Fate::kUnseen:
          ++statistics_.rejected_unseen;
          break;
        case Fate::kLeftInterval:
          ++statistics_.rejected_left_interval;
          break;
      }
      if (observer_ != nullptr) observer_->OnSeed(RecordOf(reference, i));
      pool_.Remove(i);
    }
  }
}

void Reconstructor::Convert(const ReferenceFrame& reference,
                            std::size_t i,
                            const PosedFrame& frame,
                            const Projector& projector) {
  const SeedColumns& s = pool_.columns();
  const Eigen::Vector3d bearing = Eigen::Vector3d(s.bearing_x[i], s.bearing_y[i], 1).normalized();
  const DepthEstimate<float> z =
      DepthOf<float>(options_.coordinate, {s.c0[i], s.c1[i]}, s.mu[i], s.sigma2[i]);
  const Rigid3d world_from_ref = reference.cam_from_world.Inverse();
  const Eigen::Vector3d position = world_from_ref * (bearing * static_cast<double>(z.depth));
  const Eigen::Vector3d in_cur = frame.cam_from_world * position;
  Point point;
  point.position = position.cast<float>();
  point.normal = -(world_from_ref.rotation * bearing).cast<float>();
  point.sigma = z.sigma;
  point.inlier_ratio = s.a[i] / (s.a[i] + s.b[i]);
  point.views = s.counts[i].views;
  point.footprint = z.depth / static_cast<float>(reference.camera.FocalLength());
  point.frame = FrameNumber(frame.index);
  if (const auto pixel = projector.Project(in_cur)) {
    const auto clamped = [](double v, int size) {
      return static_cast<int>(std::lround(std::clamp(v, 0.0, size - 1.0)));
    };
    point.color = frame.picture->ColorAt(clamped(pixel->x(), frame.camera.width),
                                         clamped(pixel->y(), frame.camera.height));
  }
  points_.push_back(point);
  ++statistics_.seeds_converged;
}

SeedRecord Reconstructor::RecordOf(const ReferenceFrame& reference, std::size_t i) const {
  const SeedColumns& s = pool_.columns();
  const Camera& camera = reference.camera;
  SeedRecord record;
  record.birth_frame = reference.frame_index;
  VisitModel(camera.model, [&](auto model) {
    const auto p = decltype(model)::template Distort<double>(
        camera.distortion.data(), s.bearing_x[i], s.bearing_y[i]);
    const double scale = std::ldexp(1.0, reference.level);  // see AtLevel()
    record.x = static_cast<float>((camera.fx * p.x + camera.cx + 0.5) * scale - 0.5);
    record.y = static_cast<float>((camera.fy * p.y + camera.cy + 0.5) * scale - 0.5);
  });
  record.level = static_cast<std::uint8_t>(reference.level);
  record.end_frame = last_frame_;
  record.fate = s.fate[i];
  record.views = s.counts[i].views;
  const DepthEstimate<float> z =
      DepthOf<float>(options_.coordinate, {s.c0[i], s.c1[i]}, s.mu[i], s.sigma2[i]);
  // A mean that wandered off its interval may be beyond infinity.
  if (z.depth > 0 && std::isfinite(z.depth) && std::isfinite(z.sigma)) {
    record.depth = z.depth;
    record.sigma = z.sigma;
  }
  return record;
}

void Reconstructor::ReportLiveSeeds() {
  if (observer_ == nullptr) return;
  for (const ReferenceFrame& reference : pool_.references()) {
    for (std::size_t i = reference.begin; i < reference.end; ++i) {
      if (pool_.columns().fate[i] == Fate::kAlive) observer_->OnSeed(RecordOf(reference, i));
    }
  }
}

void Reconstructor::SpawnSeeds(const PosedFrame& frame) {
  const StageTimer timer(&statistics_.spawn_seconds);
  const bool first = statistics_.frames == 0;
  if (!first && ++frames_unplanted_ < options_.plant_every) return;
  if (static_cast<double>(pool_.free_slots()) < kFreeShare * options_.max_seeds) return;
  frames_unplanted_ = 0;
  statistics_.seeds_spawned +=
      spawner_.Spawn(frame, pyramid_.levels(), points_, backend_.get(), &pool_);
}

}  // namespace livemvs
