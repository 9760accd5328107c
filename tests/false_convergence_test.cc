// From rendered frames through the reconstruction to the measure of false convergence.

#include "livemvs/eval/false_convergence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/map/finish_cloud.h"
#include "livemvs/pipeline/reconstructor.h"
#include "livemvs/synth/labels.h"

namespace livemvs {
namespace {

constexpr int kFrames = 40;
constexpr int kLabelsEvery = 8;

// In pictures this small, with paths this short, one per cent of the depth is half a pixel of
// parallax: what a good match may be off by. Falsehoods are larger.
constexpr double kTolerance = 0.03;

class Recorder : public SeedObserver {
 public:
  void OnSeed(const SeedRecord& record) override { records.push_back(record); }
  // Marks those whose points are not among the kept.
  void Finish(const std::vector<std::uint32_t>& kept) {
    std::uint32_t point = 0;
    for (SeedRecord& r : records) {
      if (r.fate != Fate::kConverged) continue;
      if (!std::binary_search(kept.begin(), kept.end(), point++)) r.fate = Fate::kTakenOut;
    }
  }
  std::vector<SeedRecord> records;
};

// A part of the hazards' orbit with the steps of a video, noisy.
SequenceOptions Sequence() {
  SequenceOptions sequence;
  sequence.path = DefaultPath("hazards");
  sequence.path.frames = kFrames;
  sequence.path.start_deg = -110;
  sequence.path.arc_deg = 35;
  sequence.camera = SyntheticCamera(320, 240);
  sequence.samples_per_pixel = 2;
  sequence.noise_sigma = 2;
  return sequence;
}

struct Recording {
  SyntheticScene scene{{.name = "hazards"}};
  std::vector<SyntheticFrame> frames = RenderSequence(scene, Sequence());
  std::vector<LabelledView> views;

  Recording() {
    for (int i = 0; i < kFrames; i += kLabelsEvery) {
      const PosedFrame& f = frames[i].frame;
      views.push_back(
          {f.index, f.camera, f.cam_from_world, LabelSequenceFrame(scene, Sequence(), frames[i])});
    }
  }
};

FalseConvergence Measure(const Recording& recording, const Options& options) {
  SceneRange range;  // as where little is known of the scene
  range.near = 0.25;
  range.far = 1.5;
  Recorder recorder;
  Reconstructor reconstructor(options, range);
  reconstructor.SetObserver(&recorder);
  for (const SyntheticFrame& f : recording.frames) reconstructor.AddFrame(f.frame);
  reconstructor.ReportLiveSeeds();
  PointCloud cloud = reconstructor.TakePoints();
  recorder.Finish(FinishCloud(options, std::nullopt, &cloud).kept);
  return MeasureFalseConvergence(recorder.records,
                                 recording.views,
                                 MeshSurface(recording.scene.mesh()),
                                 {.tolerance = kTolerance});
}

const ConvergenceCounts& Of(const FalseConvergence& result, const std::string& key) {
  std::size_t i = 0;
  while (kLabelClasses.at(i).key != key) ++i;
  return result.classes[i];
}

TEST(FalseConvergence, OfThePublishedConstantsIsMuchLargerWithoutTexture) {
  const Recording recording;
  const FalseConvergence paper = Measure(recording, PaperOptions());
  const FalseConvergence ours = Measure(recording, Options{});
  const ConvergenceCounts& plain_paper = Of(paper, "textureless_off_edges");
  const ConvergenceCounts& plain_ours = Of(ours, "textureless_off_edges");
  ASSERT_GT(plain_paper.planted, 200U);
  EXPECT_GT(plain_paper.FalseRate(), 0.3);
  // Patches of the coarse levels reach over edges that are two pixels away.
  EXPECT_LT(plain_ours.FalseRate(), 0.03);
  EXPECT_GT(plain_paper.falsely_converged, 10 * plain_ours.falsely_converged);
  // On ordinary ground both mostly find the surface.
  const ConvergenceCounts& ordinary = Of(ours, "no_label");
  EXPECT_GT(ordinary.converged, 1000U);
  EXPECT_LT(ordinary.FalseShare(), 0.05);
}

TEST(FalseConvergence, AtEdgesIsLessWhereBothHalvesOfAPatchMustMatch) {
  const Recording recording;
  Options anyhow, asked;
  anyhow.min_side_ncc = -1;
  asked.min_side_ncc = 0.3F;  // the default takes more of both
  const FalseConvergence without = Measure(recording, anyhow);
  const FalseConvergence with = Measure(recording, asked);
  const ConvergenceCounts& before = Of(without, "occluding_edge");
  const ConvergenceCounts& now = Of(with, "occluding_edge");
  ASSERT_GT(before.falsely_converged, 100U);
  // Where a seed was refused another may be planted, so that rates alone would not tell.
  EXPECT_LT(now.FalseRate(), 0.85 * before.FalseRate());
  EXPECT_LT(now.FalseShare(), 0.95 * before.FalseShare());
  EXPECT_LT(static_cast<double>(now.falsely_converged),
            0.85 * static_cast<double>(before.falsely_converged));
  // What is right mostly stays.
  const auto kept = static_cast<double>(Of(with, "no_label").converged);
  EXPECT_GT(kept, 0.9 * static_cast<double>(Of(without, "no_label").converged));
}

TEST(FalseConvergence, IsLessInTheCloudWhereNothingMayOverhang) {
  const Recording recording;
  Options anyhow, held;
  anyhow.overhang_px = 0;
  held.overhang_px = 24;  // gaps between things are a third as wide as in pictures of usual size
  const FalseConvergence without = Measure(recording, anyhow);
  const FalseConvergence with = Measure(recording, held);
  const ConvergenceCounts& before = Of(without, "occluding_edge");
  const ConvergenceCounts& now = Of(with, "occluding_edge");
  // The cloud is all that differs.
  ASSERT_EQ(now.falsely_converged, before.falsely_converged);
  ASSERT_GT(before.false_points, 100U);
  EXPECT_LT(static_cast<double>(now.false_points), 0.75 * static_cast<double>(before.false_points));
  // What is right mostly stays.
  const auto right = [](const ConvergenceCounts& c) {
    return static_cast<double>(c.points - c.false_points);
  };
  EXPECT_GT(right(Of(with, "no_label")), 0.93 * right(Of(without, "no_label")));
}

TEST(FalseConvergence, IsLessInTheCloudWithoutTheRimsOfSurfaces) {
  const Recording recording;
  Options anyhow;
  anyhow.rim_px = 0;
  const FalseConvergence without = Measure(recording, anyhow);
  const FalseConvergence with = Measure(recording, Options{});
  const ConvergenceCounts& before = Of(without, "occluding_edge");
  const ConvergenceCounts& now = Of(with, "occluding_edge");
  // The cloud is all that differs.
  ASSERT_EQ(now.falsely_converged, before.falsely_converged);
  ASSERT_GT(before.false_points, 100U);
  EXPECT_LT(static_cast<double>(now.false_points), 0.5 * static_cast<double>(before.false_points));
  // What is right mostly stays.
  const auto right = [](const ConvergenceCounts& c) {
    return static_cast<double>(c.points - c.false_points);
  };
  EXPECT_GT(right(Of(with, "no_label")), 0.9 * right(Of(without, "no_label")));
}

}  // namespace
}  // namespace livemvs
