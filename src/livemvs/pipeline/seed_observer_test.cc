#include "livemvs/pipeline/seed_observer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "livemvs/pipeline/reconstructor.h"
#include "plane_scene.h"

namespace livemvs {
namespace {

using testing_support::PlaneScene;
using testing_support::SidewaysPath;
using testing_support::TestOptions;

constexpr int kObservedFrames = 30;

class Recorder : public SeedObserver {
 public:
  void OnSeed(const SeedRecord& record) override { records.push_back(record); }

  std::int64_t Count(Fate fate) const {
    std::int64_t count = 0;
    for (const SeedRecord& r : records) count += r.fate == fate;
    return count;
  }

  std::vector<SeedRecord> records;
};

SceneRange ObservedRange() {
  SceneRange range;
  range.near = 0.6;
  range.far = 1.8;
  return range;
}

// Frames whose indices are not 0, 1, ...: 100, 107, ...
std::vector<PosedFrame> Frames(const PlaneScene& scene) {
  std::vector<PosedFrame> frames = scene.Render(SidewaysPath(kObservedFrames));
  for (PosedFrame& frame : frames) frame.index = 100 + 7 * frame.index;
  return frames;
}

TEST(SeedObserver, HearsOfEverySeedOnce) {
  Options options = TestOptions();
  options.max_age = 22;
  options.max_unseen = 3;
  Recorder recorder;
  Reconstructor reconstructor(options, ObservedRange());
  reconstructor.SetObserver(&recorder);
  for (const PosedFrame& frame : Frames(PlaneScene())) reconstructor.AddFrame(frame);
  const ReconstructionStatistics& s = reconstructor.statistics();
  EXPECT_GT(s.seeds_converged, 100);
  EXPECT_EQ(recorder.Count(Fate::kConverged), s.seeds_converged);
  EXPECT_EQ(recorder.Count(Fate::kOutlier), s.rejected_outlier);
  EXPECT_EQ(recorder.Count(Fate::kAged), s.rejected_aged);
  EXPECT_EQ(recorder.Count(Fate::kUnseen), s.rejected_unseen);
  EXPECT_EQ(recorder.Count(Fate::kLeftInterval), s.rejected_left_interval);
  EXPECT_EQ(recorder.Count(Fate::kOneSided), s.rejected_one_sided);
  EXPECT_EQ(recorder.Count(Fate::kAlive), 0);
  reconstructor.ReportLiveSeeds();
  EXPECT_EQ(recorder.Count(Fate::kAlive), static_cast<std::int64_t>(reconstructor.live_seeds()));
  EXPECT_EQ(static_cast<std::int64_t>(recorder.records.size()), s.seeds_spawned);
  for (const SeedRecord& r : recorder.records) {
    EXPECT_EQ((r.birth_frame - 100) % 7, 0);
    EXPECT_GE(r.birth_frame, 100);
    EXPECT_LE(r.end_frame, 100 + 7 * (kObservedFrames - 1));
    EXPECT_GE(r.end_frame, r.birth_frame);
  }
}

class SeedObserverWithLens : public testing::TestWithParam<CameraModel> {};

TEST_P(SeedObserverWithLens, RecordsLeadBackToPixelAndPoint) {
  PlaneScene scene;
  scene.camera.model = GetParam();
  if (GetParam() == CameraModel::kBrownConrady) scene.camera.distortion = {-0.15, 0.03, 1e-3};
  if (GetParam() == CameraModel::kKannalaBrandt) scene.camera.distortion = {0.03, -0.01};
  const std::vector<PosedFrame> frames = Frames(scene);
  Recorder recorder;
  Reconstructor reconstructor(TestOptions(), ObservedRange());
  reconstructor.SetObserver(&recorder);
  for (const PosedFrame& frame : frames) reconstructor.AddFrame(frame);
  const Projector projector(scene.camera);
  std::size_t next = 0;  // points come in the order of their seeds' ends
  for (const SeedRecord& r : recorder.records) {
    // Seeds are planted on pixels; the bearing is kept in single precision.
    ASSERT_NEAR(r.x, std::round(r.x), 1e-3);
    ASSERT_NEAR(r.y, std::round(r.y), 1e-3);
    if (r.fate != Fate::kConverged) continue;
    const Point& point = reconstructor.points()[next++];
    const PosedFrame& birth = frames[static_cast<std::size_t>((r.birth_frame - 100) / 7)];
    const Eigen::Vector3d bearing = projector.Unproject({r.x, r.y})->normalized();
    const Eigen::Vector3d place =
        birth.cam_from_world.Inverse() * (static_cast<double>(r.depth) * bearing);
    ASSERT_LT((place - point.position.cast<double>()).norm(), 1e-5);
    ASSERT_EQ(r.sigma, point.sigma);
    ASSERT_EQ(r.views, point.views);
  }
  EXPECT_EQ(next, reconstructor.points().size());
  EXPECT_GT(next, 100U);
}

INSTANTIATE_TEST_SUITE_P(Models,
                         SeedObserverWithLens,
                         testing::Values(CameraModel::kPinhole,
                                         CameraModel::kBrownConrady,
                                         CameraModel::kKannalaBrandt));

TEST(SeedObserver, RecordsOfCoarseSeedsLeadBackToThePoint) {
  const PlaneScene scene;
  const std::vector<PosedFrame> frames = Frames(scene);
  Options options = TestOptions();
  options.levels = 3;
  Recorder recorder;
  Reconstructor reconstructor(options, ObservedRange());
  reconstructor.SetObserver(&recorder);
  for (const PosedFrame& frame : frames) reconstructor.AddFrame(frame);
  const Projector projector(scene.camera);
  std::size_t next = 0;
  std::size_t coarse = 0;
  for (const SeedRecord& r : recorder.records) {
    if (r.fate != Fate::kConverged) continue;
    // The centre of a coarse pixel lies between those of the frame.
    coarse += std::abs(r.x - std::round(r.x)) > 0.4F;
    const PosedFrame& birth = frames[static_cast<std::size_t>((r.birth_frame - 100) / 7)];
    const Eigen::Vector3d in_birth =
        birth.cam_from_world * reconstructor.points()[next++].position.cast<double>();
    const auto pixel = projector.Project(in_birth);
    ASSERT_TRUE(pixel);
    ASSERT_NEAR(pixel->x(), r.x, 0.01);
    ASSERT_NEAR(pixel->y(), r.y, 0.01);
  }
  EXPECT_GT(coarse, 100U);
}

TEST(SeedObserver, ChangesNothing) {
  const std::vector<PosedFrame> frames = Frames(PlaneScene());
  Recorder recorder;
  Reconstructor watched(TestOptions(), ObservedRange()), alone(TestOptions(), ObservedRange());
  watched.SetObserver(&recorder);
  for (const PosedFrame& frame : frames) {
    watched.AddFrame(frame);
    alone.AddFrame(frame);
  }
  alone.ReportLiveSeeds();  // to nobody
  ASSERT_EQ(watched.points().size(), alone.points().size());
  for (std::size_t i = 0; i < alone.points().size(); ++i) {
    ASSERT_EQ(watched.points()[i].position, alone.points()[i].position);
  }
}

}  // namespace
}  // namespace livemvs
