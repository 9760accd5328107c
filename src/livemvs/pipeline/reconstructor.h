#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "livemvs/backend/backend.h"
#include "livemvs/core/frame.h"
#include "livemvs/core/options.h"
#include "livemvs/core/point.h"
#include "livemvs/core/scene_range.h"
#include "livemvs/pipeline/pyramid.h"
#include "livemvs/pipeline/seed_observer.h"
#include "livemvs/pipeline/seed_pool.h"

namespace livemvs {

/// What became of the seeds and where the time went, since the start.
struct ReconstructionStatistics {
  std::int64_t frames = 0;
  std::int64_t seeds_spawned = 0;
  std::int64_t seeds_converged = 0;
  std::int64_t rejected_outlier = 0;        ///< Inlier ratio too low with certainty.
  std::int64_t rejected_aged = 0;           ///< Not converged in time.
  std::int64_t rejected_unseen = 0;         ///< Out of view for too long.
  std::int64_t rejected_left_interval = 0;  ///< Wandered off the range.
  std::int64_t rejected_one_sided = 0;      ///< A half of the patch did not match, see SideCheck.
  UpdateStatistics updates;
  double spawn_seconds = 0;
  double update_seconds = 0;
  double collect_seconds = 0;
};

/// Algorithm 1 of [VH11]: a pool of seeds that posed frames update, and the points they turn
/// into. Independent of where frames, poses and viewers are. The result does not depend on the
/// number of threads. Not thread-safe.
class Reconstructor {
 public:
  /// @throws std::invalid_argument naming the option that is out of its range.
  /// @throws DeviceError where Options::backend is a GPU that cannot be used.
  Reconstructor(const Options& options, const SceneRange& range);
  /// On another backend than the options'.
  Reconstructor(const Options& options, const SceneRange& range, std::unique_ptr<Backend> backend);
  ~Reconstructor();

  /// Runs Algorithm 1 on one frame and returns the points that converged in it; valid until the
  /// next call. Where the range has a box with a margin, some lie in the margin (SoughtBox());
  /// FinishCloud() needs those, and drops them. Where the GPU fails and Options::backend is kAuto,
  /// the CPU goes on: the points stay, the seeds are planted anew.
  /// @throws std::invalid_argument where the picture's size is not its camera's.
  /// @throws DeviceError where the GPU fails otherwise; the points stay.
  std::span<const Point> AddFrame(const PosedFrame& frame);

  /// Tells `observer`, which must outlive the reconstruction, of every seed that ends from now on;
  /// nullptr: nobody. It changes nothing of the result.
  void SetObserver(SeedObserver* observer) { observer_ = observer; }
  /// Tells the observer of the seeds that are alive, at the end of a run.
  void ReportLiveSeeds();

  /// All points so far; normals are directions towards the camera that planted the seed.
  const PointCloud& points() const { return points_; }
  /// Hands all points over; the reconstruction may go on, but no longer knows what they cover.
  PointCloud TakePoints() {
    pool_.backend().ForgetPoints();
    return std::exchange(points_, {});
  }
  /// Takes the points of an earlier run over: what they cover needs no seeds. Before any frame.
  void Restore(PointCloud points) {
    pool_.backend().ForgetPoints();
    points_ = std::move(points);
  }
  std::size_t live_seeds() const { return pool_.size(); }
  /// The live seeds, until the next call of AddFrame(): for looking at them.
  const SeedPool& pool() const { return pool_; }
  const ReconstructionStatistics& statistics() const { return statistics_; }
  std::string backend_name() const { return pool_.backend().name(); }

 private:
  struct Workers;  // the threads, options.threads of them

  void RunAlgorithm(const PosedFrame& frame);
  void GoOnWithCpu(const DeviceError& error);
  std::vector<SeedGroup> GroupsIn(const PosedFrame& frame,
                                  const std::vector<ReferenceFrame>& references) const;
  void SpawnSeeds(const PosedFrame& frame);
  void UpdateSeeds(const PosedFrame& frame);
  void CollectSeeds(const PosedFrame& frame);
  void CountEnd(Fate fate);
  Point PointOf(const ReferenceFrame& reference,
                const EndedSeed& ended,
                const PosedFrame& frame,
                const Projector& projector) const;
  SeedRecord RecordOf(const ReferenceFrame& reference, const SeedState& seed) const;

  Options options_;
  std::unique_ptr<Workers> workers_;
  SeedPool pool_;
  SceneRange range_;
  Pyramid pyramid_;
  PointCloud points_;
  ReconstructionStatistics statistics_;
  SeedObserver* observer_ = nullptr;
  std::int64_t last_frame_ = 0;  // index of the latest frame
  int frames_to_wait_ = 0;       // before seeds are planted again
};

}  // namespace livemvs
