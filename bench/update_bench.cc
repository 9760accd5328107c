// Updates of seeds per second, everything in them: projection, search, NCC, fusion, judgement.

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "livemvs/core/posterior.h"
#include "livemvs/pipeline/reconstructor.h"
#include "livemvs/synth/sequence.h"

namespace livemvs {
namespace {

constexpr int kFrames = 40;

// A hand-held orbit round the still life, VGA, without shadows: quick to make.
const std::vector<PosedFrame>& Frames() {
  static const std::vector<PosedFrame> frames = [] {
    const SyntheticScene scene({.name = "table", .seed = 1, .shadows = false});
    SequenceOptions sequence;
    sequence.path = DefaultPath("table");
    sequence.path.arc_deg *= kFrames / 180.0;
    sequence.path.frames = kFrames;
    sequence.samples_per_pixel = 1;
    sequence.noise_sigma = 1.5;
    sequence.ground_truth = false;
    std::vector<PosedFrame> rendered;
    for (int i = 0; i < kFrames; ++i) {
      rendered.push_back(RenderSequenceFrame(scene, sequence, i).frame);
    }
    return rendered;
  }();
  return frames;
}

// Seeds in the state in which a real run has them: some new, some nearly converged, some hopeless.
void BM_Frame(benchmark::State& state) {
  Options options = OptionsFromPreset(state.range(0) == 0 ? "default" : "paper");
  options.max_seeds = 60'000;
  options.threads = static_cast<int>(state.range(1));
  SceneRange range;
  range.near = 0.2;
  range.far = 1.2;
  double update_seconds = 0;
  std::int64_t updates = 0;
  for (auto _ : state) {
    Reconstructor reconstructor(options, range);
    for (const PosedFrame& frame : Frames()) reconstructor.AddFrame(frame);
    update_seconds += reconstructor.statistics().update_seconds;
    updates += reconstructor.statistics().updates.total();
    benchmark::DoNotOptimize(reconstructor.points().size());
  }
  state.counters["updates/s"] = static_cast<double>(updates) / update_seconds;
  state.SetItemsProcessed(updates);
}
BENCHMARK(BM_Frame)
    ->ArgNames({"paper", "threads"})
    ->Args({0, 1})
    ->Args({0, 2})
    ->Args({1, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_Fuse(benchmark::State& state) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<Posterior<float>> seeds(4096);
  for (auto& q : seeds) {
    q = {uniform(random),
         0.1F * uniform(random),
         1 + 20 * uniform(random),
         1 + 20 * uniform(random)};
  }
  for (auto _ : state) {
    for (auto& q : seeds) q.mu = Fuse(q, 0.5F, 1e-3F, 1.0F).posterior.mu;
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(seeds.size()));
}
BENCHMARK(BM_Fuse);

}  // namespace
}  // namespace livemvs
