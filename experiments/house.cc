#include <memory>
#include <string>
#include <vector>

#include "csv.h"
#include "experiments.h"
#include "livemvs/eval/evaluate.h"
#include "livemvs/eval/surface.h"
#include "livemvs/map/finish_cloud.h"
#include "livemvs/pipeline/reconstructor.h"
#include "livemvs/pipeline/search_mode.h"
#include "livemvs/synth/sequence.h"

namespace livemvs::experiments {
namespace {

constexpr int kSkip = 20;      // [VH11] Sec. 5: every 20th frame
constexpr double kReach = 10;  // of the curves [mm]
constexpr int kSteps = 100;    // of the curves

// One reconstruction from every `step`-th frame.
struct Run {
  std::string name;
  int step;
  int frames;
  Options options;
  std::unique_ptr<Reconstructor> reconstructor;
};

std::vector<PosedCamera> EveryStep(const SequenceOptions& sequence, int step) {
  std::vector<PosedCamera> cameras;
  for (int i = 0; i < sequence.path.frames; i += step) {
    cameras.push_back({sequence.camera, PoseAt(sequence.path, i)});
  }
  return cameras;
}

std::vector<Run> MakeRuns(const SequenceOptions& sequence, const Box& box) {
  std::vector<Run> runs;
  for (const char* preset : {"paper", "default"}) {
    for (const int step : {1, kSkip}) {
      const std::vector<PosedCamera> cameras = EveryStep(sequence, step);
      const SceneRange range = RangeOfBox(box, 0, cameras);
      const Options options = ResolveSearch(cameras, range, OptionsFromPreset(preset));
      runs.push_back({std::string(preset) + " " + std::to_string(cameras.size()) + " frames",
                      step,
                      0,
                      options,
                      std::make_unique<Reconstructor>(options, range)});
    }
  }
  return runs;
}

SequenceOptions Video(bool quick) {
  SequenceOptions sequence;
  sequence.path = DefaultPath("house");
  if (quick) {
    sequence.camera = SyntheticCamera(160, 120);
    sequence.path.frames = 80;
    sequence.path.arc_deg = 60;
  }
  sequence.noise_sigma = kNoise;
  sequence.ground_truth = false;
  return sequence;
}

}  // namespace

void House(const Settings& settings) {
  const SyntheticScene scene({.name = "house"});
  const SequenceOptions sequence = Video(settings.quick);
  std::vector<Run> runs = MakeRuns(sequence, scene.box());
  std::vector<PosedCamera> cameras;
  for (int i = 0; i < sequence.path.frames; ++i) {
    const SyntheticFrame frame = RenderSequenceFrame(scene, sequence, i);
    for (Run& run : runs) {
      if (i % run.step != 0) continue;
      run.reconstructor->AddFrame(frame.frame);
      ++run.frames;
    }
    if (i % kSkip == 0) cameras.push_back({sequence.camera, frame.frame.cam_from_world});
    ShowProgress("frames of the house", i + 1, sequence.path.frames);
  }

  const MeshSurface surface(scene.mesh());
  EvaluationOptions options;
  options.box = scene.box();
  options.min_cameras = settings.quick ? 2 : options.min_cameras;
  Csv curves(settings.tables / "fig7_curves.csv", "run,distance [mm],accuracy,completeness");
  Csv summary(settings.tables / "fig7_summary.csv",
              "run,frames,points,accuracy 0.5 mm,1 mm,2 mm,5 mm,completeness 0.5 mm,1 mm,2 mm,"
              "5 mm,median error [mm],90 % error [mm]");
  for (Run& run : runs) {
    PointCloud cloud = run.reconstructor->TakePoints();
    FinishCloud(run.options, scene.box(), &cloud);
    const Evaluation e = EvaluateAgainstMesh(cloud, surface, cameras, options);
    const auto accuracy = [&](double mm) { return ShareWithin(e.accuracy, mm / kMillimetres); };
    const auto complete = [&](double mm) { return ShareWithin(e.completeness, mm / kMillimetres); };
    for (int i = 0; i <= kSteps; ++i) {
      const double mm = kReach * i / kSteps;
      curves.Row(run.name, mm, accuracy(mm), complete(mm));
    }
    summary.Row(run.name,
                run.frames,
                cloud.size(),
                accuracy(0.5),
                accuracy(1),
                accuracy(2),
                accuracy(5),
                complete(0.5),
                complete(1),
                complete(2),
                complete(5),
                kMillimetres * Percentile(e.accuracy, 50).value_or(0),
                kMillimetres * Percentile(e.accuracy, 90).value_or(0));
  }
}

}  // namespace livemvs::experiments
