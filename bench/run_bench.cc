// Algorithm 1 on frames in memory: seeds in the states in which a real run has them, some new, some
// nearly converged, some hopeless. "updates/s" counts the time of step 2 alone: projection, search,
// NCC, fusion and judgement of the seeds that meet the frame. Where the kernel is what is measured,
// that is every living seed.

#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>

#include "frames.h"
#include "livemvs/pipeline/reconstructor.h"

namespace livemvs {
namespace {

constexpr double kPaperUpdates = 15e6;  // [VH11] Sec. 5: a second, on a GTX 260

void Report(const ReconstructionStatistics& s, std::size_t seeds, benchmark::State* state) {
  const double ms = 1000.0 / static_cast<double>(s.frames);
  const auto updates = static_cast<double>(s.updates.total());
  state->counters["updates/s"] = updates / s.update_seconds;
  state->counters["vs_paper"] = updates / s.update_seconds / kPaperUpdates;
  state->counters["update_ms"] = s.update_seconds * ms;
  state->counters["spawn_ms"] = s.spawn_seconds * ms;
  state->counters["collect_ms"] = s.collect_seconds * ms;
  state->counters["updates/frame"] = updates / static_cast<double>(s.frames);
  state->counters["alive"] = static_cast<double>(seeds);
  state->counters["frames/s"] = benchmark::Counter(static_cast<double>(s.frames),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

// The whole sequence once per iteration.
void RunAll(const Options& options, benchmark::State* state) {
  const BenchSequence& sequence = Sequence();
  for (auto _ : *state) {
    Reconstructor reconstructor(options, sequence.range);
    for (const PosedFrame& frame : sequence.frames) reconstructor.AddFrame(frame);
    benchmark::DoNotOptimize(reconstructor.points().size());
    Report(reconstructor.statistics(), reconstructor.live_seeds(), state);
  }
}

void BM_Run(benchmark::State& state) {
  Options options = OptionsFromPreset(state.range(0) == 0 ? "default" : "paper");
  options.threads = static_cast<int>(state.range(1));
  RunAll(options, &state);
}
BENCHMARK(BM_Run)
    ->ArgNames({"paper", "threads"})
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The default preset, but that every seed meets every frame.
Options EveryFrame() {
  Options options;
  options.min_move = 0;
  return options;
}

void BM_EveryFrame(benchmark::State& state) {
  Options options = EveryFrame();
  options.threads = static_cast<int>(state.range(0));
  RunAll(options, &state);
}
BENCHMARK(BM_EveryFrame)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_Instructions(benchmark::State& state) {
  constexpr const char* kNames[] = {
      "portable", "AVX2", "AVX-512", "AVX-512 VNNI", "AVX-512 VNNI gathers"};
  const char* name = kNames[state.range(0)];
  state.SetLabel(name);
  ::setenv(kInstructionsVariable, name, 1);
  try {
    Options options = EveryFrame();
    options.threads = 1;
    RunAll(options, &state);
  } catch (const std::invalid_argument& e) {
    state.SkipWithError(e.what());
  }
  ::unsetenv(kInstructionsVariable);
}
BENCHMARK(BM_Instructions)->DenseRange(0, 4)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_Seeds(benchmark::State& state) {
  Options options = EveryFrame();
  options.max_seeds = static_cast<int>(state.range(0)) * 1000;
  RunAll(options, &state);
}
BENCHMARK(BM_Seeds)
    ->ArgName("thousands")
    ->Arg(10)
    ->Arg(50)
    ->Arg(250)
    ->Arg(1000)
    ->Arg(4000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The same on a GPU. Skipped where there is none.
void BM_Cuda(benchmark::State& state) {
  Options options = EveryFrame();
  options.max_seeds = static_cast<int>(state.range(0)) * 1000;
  options.backend = BackendChoice::kCuda;
  try {
    RunAll(options, &state);
  } catch (const DeviceError& e) {
    state.SkipWithError(e.what());
  }
}
BENCHMARK(BM_Cuda)
    ->ArgName("thousands")
    ->Arg(250)
    ->Arg(1000)
    ->Arg(4000)
    ->Arg(16000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void BM_Window(benchmark::State& state) {
  Options options = EveryFrame();
  options.search_radius_px = static_cast<float>(state.range(0));
  RunAll(options, &state);
}
BENCHMARK(BM_Window)
    ->ArgName("radius_px")
    ->Arg(1)
    ->Arg(2)
    ->Arg(3)
    ->Arg(5)
    ->Arg(8)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The sequence forth and back, again and again: what a frame costs in the last lap. It must not
// grow with the number of laps.
void BM_Laps(benchmark::State& state) {
  const BenchSequence& sequence = Sequence();
  const auto frames = static_cast<std::int64_t>(sequence.frames.size());
  for (auto _ : state) {
    Reconstructor reconstructor(Options(), sequence.range);
    std::chrono::steady_clock::time_point start;
    for (std::int64_t lap = 0; lap < state.range(0); ++lap) {
      start = std::chrono::steady_clock::now();
      for (std::int64_t i = 0; i < frames; ++i) {
        PosedFrame frame = sequence.frames[lap % 2 == 0 ? i : frames - 1 - i];
        frame.index = lap * frames + i;
        reconstructor.AddFrame(frame);
      }
    }
    const std::chrono::duration<double> last = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(last.count());
    state.counters["frame_ms"] = 1000 * last.count() / static_cast<double>(frames);
    state.counters["points"] = static_cast<double>(reconstructor.points().size());
  }
}
BENCHMARK(BM_Laps)
    ->ArgName("laps")
    ->Arg(1)
    ->Arg(2)
    ->Arg(8)
    ->Arg(16)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

}  // namespace
}  // namespace livemvs
