#include "livemvs/pipeline/reconstructor.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "livemvs/core/lean.h"
#include "livemvs/core/log.h"
#include "livemvs/core/texture.h"
#include "livemvs/parallel/parallel_for.h"
#include "livemvs/pipeline/seed_groups.h"
#include "livemvs/pipeline/side_check.h"

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

int PlantEvery(const Options& options) {
  if (options.plant_every > 0) return options.plant_every;
  return options.search == Search::kFull ? 1 : 6;
}

std::unique_ptr<Backend> MakeCheckedBackend(const Options& options) {
  options.Check();
  return MakeBackend(options);
}

// Where the texture of a seed's patch lies, of which the reference camera saw the middle from
// `towards_camera` [world].
std::uint8_t LeanOf(const Options& options,
                    const ReferenceFrame& reference,
                    const EndedSeed& ended,
                    const Eigen::Vector3f& towards_camera) {
  const TextureMoments texture = MomentsOfTexture(
      NoiseVariance(options, reference.level), ended.patch + kPatchPixels / 2, kPatchSize);
  if (!(texture.sum > 0)) return kLeanUnknown;
  if (IsCentred(kCentredPx, texture)) return kLeanNowhere;
  const Eigen::Vector2d step =
      BearingPerPixel(reference.camera, ended.seed.bearing_x, ended.seed.bearing_y) *
      Eigen::Vector2d(texture.x, texture.y);
  const Eigen::Vector3d in_world =
      reference.cam_from_world.rotation.transpose() * Eigen::Vector3d(step.x(), step.y(), 0);
  return LeanCode(towards_camera, in_world.normalized().cast<float>());
}

}  // namespace

struct Reconstructor::Workers {
  explicit Workers(int threads) : arena(threads > 0 ? threads : tbb::task_arena::automatic) {}
  tbb::task_arena arena;
};

Reconstructor::~Reconstructor() = default;

Reconstructor::Reconstructor(const Options& options, const SceneRange& range)
    : Reconstructor(options, range, MakeCheckedBackend(options)) {}

Reconstructor::Reconstructor(const Options& options,
                             const SceneRange& range,
                             std::unique_ptr<Backend> backend)
    : options_(options),
      workers_(std::make_unique<Workers>(options.threads)),
      pool_(std::move(backend)),
      range_(range) {
  options.Check();
  range.Check();
}

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
  try {
    workers_->arena.execute([&] { RunAlgorithm(frame); });
  } catch (const DeviceError& e) {
    if (options_.backend != BackendChoice::kAuto) throw;
    GoOnWithCpu(e);
  }
  return std::span<const Point>(points_).subspan(points_before);
}

void Reconstructor::GoOnWithCpu(const DeviceError& error) {
  LogWarning(std::string(error.what()) + "; the CPU goes on, with new seeds");
  pool_ = SeedPool(MakeCpuBackend(options_));
  frames_to_wait_ = 0;
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

std::vector<SeedGroup> Reconstructor::GroupsIn(
    const PosedFrame& frame, const std::vector<ReferenceFrame>& references) const {
  return MakeGroups(references, frame.camera, frame.cam_from_world, pyramid_.levels().size());
}

void Reconstructor::UpdateSeeds(const PosedFrame& frame) {
  const StageTimer timer(&statistics_.update_seconds);
  pool_.backend().SetFrame(pyramid_.levels());
  const auto levels = static_cast<int>(pyramid_.levels().size());
  const std::vector<ReferenceFrame> met =
      pool_.Meet(frame.cam_from_world, levels, static_cast<double>(options_.min_move));
  statistics_.updates += pool_.backend().Update(GroupsIn(frame, met), frame.camera.model);
}

void Reconstructor::CollectSeeds(const PosedFrame& frame) {
  const StageTimer timer(&statistics_.collect_seconds);
  struct End {
    const ReferenceFrame* reference;
    const EndedSeed* ended;
    Fate fate;
    Point point;  // of one that converged
  };
  std::vector<End> ends;
  pool_.TakeEnded([&](const ReferenceFrame& reference, const EndedSeed& ended) {
    ends.push_back({&reference, &ended, ended.seed.fate, {}});
  });
  const Projector projector(frame.camera);
  const SideCheck sides(options_, frame.cam_from_world, projector, pyramid_.levels());
  ParallelFor(ends.size(), [&](std::size_t i) {
    End& end = ends[i];
    if (end.fate != Fate::kConverged) return;
    if (sides.Passes(*end.reference, *end.ended)) {
      end.point = PointOf(*end.reference, *end.ended, frame, projector);
    } else {
      end.fate = Fate::kOneSided;
    }
  });
  for (const End& end : ends) {
    CountEnd(end.fate);
    if (end.fate == Fate::kConverged) points_.push_back(end.point);
    if (observer_ == nullptr) continue;
    SeedRecord record = RecordOf(*end.reference, end.ended->seed);
    record.fate = end.fate;
    observer_->OnSeed(record);
  }
}

void Reconstructor::CountEnd(Fate fate) {
  switch (fate) {
    case Fate::kAlive:
    case Fate::kTakenOut:
    case Fate::kRemoved:
      break;
    case Fate::kConverged:
      ++statistics_.seeds_converged;
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
    case Fate::kOneSided:
      ++statistics_.rejected_one_sided;
      break;
  }
}

Point Reconstructor::PointOf(const ReferenceFrame& reference,
                             const EndedSeed& ended,
                             const PosedFrame& frame,
                             const Projector& projector) const {
  const SeedState& seed = ended.seed;
  const Posterior<float>& q = seed.posterior;
  const Eigen::Vector3d bearing = Eigen::Vector3d(seed.bearing_x, seed.bearing_y, 1).normalized();
  const DepthEstimate<float> z = DepthOf<float>(options_.coordinate, seed.interval, q.mu, q.sigma2);
  const Rigid3d world_from_ref = reference.cam_from_world.Inverse();
  const Eigen::Vector3d position = world_from_ref * (bearing * static_cast<double>(z.depth));
  const Eigen::Vector3d in_cur = frame.cam_from_world * position;
  Point point;
  point.position = position.cast<float>();
  point.normal = -(world_from_ref.rotation * bearing).cast<float>();
  point.sigma = z.sigma;
  point.inlier_ratio = q.a / (q.a + q.b);
  point.views = seed.counts.views;
  point.level = static_cast<std::uint8_t>(reference.level);
  point.lean = LeanOf(options_, reference, ended, point.normal);
  point.footprint = z.depth / static_cast<float>(reference.camera.FocalLength());
  point.frame = FrameNumber(frame.index);
  if (const auto pixel = projector.Project(in_cur)) {
    const auto clamped = [](double v, int size) {
      return static_cast<int>(std::lround(std::clamp(v, 0.0, size - 1.0)));
    };
    point.color = frame.picture->ColorAt(clamped(pixel->x(), frame.camera.width),
                                         clamped(pixel->y(), frame.camera.height));
  }
  return point;
}

SeedRecord Reconstructor::RecordOf(const ReferenceFrame& reference, const SeedState& seed) const {
  const Camera& camera = reference.camera;
  SeedRecord record;
  record.birth_frame = reference.frame_index;
  VisitModel(camera.model, [&](auto model) {
    const auto p = decltype(model)::template Distort<double>(
        camera.distortion.data(), seed.bearing_x, seed.bearing_y);
    const double scale = std::ldexp(1.0, reference.level);  // see AtLevel()
    record.x = static_cast<float>((camera.fx * p.x + camera.cx + 0.5) * scale - 0.5);
    record.y = static_cast<float>((camera.fy * p.y + camera.cy + 0.5) * scale - 0.5);
  });
  record.level = static_cast<std::uint8_t>(reference.level);
  record.end_frame = last_frame_;
  record.fate = seed.fate;
  record.views = seed.counts.views;
  const DepthEstimate<float> z =
      DepthOf<float>(options_.coordinate, seed.interval, seed.posterior.mu, seed.posterior.sigma2);
  // A mean that wandered off its interval may be beyond infinity.
  if (z.depth > 0 && std::isfinite(z.depth) && std::isfinite(z.sigma)) {
    record.depth = z.depth;
    record.sigma = z.sigma;
  }
  return record;
}

void Reconstructor::ReportLiveSeeds() {
  if (observer_ == nullptr) return;
  pool_.ForEachAlive(1, [&](const ReferenceFrame& reference, const SeedState& seed) {
    observer_->OnSeed(RecordOf(reference, seed));
  });
}

void Reconstructor::SpawnSeeds(const PosedFrame& frame) {
  const StageTimer timer(&statistics_.spawn_seconds);
  if (frames_to_wait_ > 0) {
    --frames_to_wait_;
    return;
  }
  if (static_cast<double>(pool_.free_slots()) < kFreeShare * options_.max_seeds) return;
  frames_to_wait_ = PlantEvery(options_) - 1;
  pool_.Compact();
  std::vector<SeedGroup> groups;
  if (options_.cover_radius_px >= 0) groups = GroupsIn(frame, pool_.references());
  statistics_.seeds_spawned +=
      pool_.Plant(frame.index, {{frame.camera, frame.cam_from_world}, &range_, groups, points_});
}

}  // namespace livemvs
