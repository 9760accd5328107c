// The parts of a frame's budget, each by itself.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <random>
#include <vector>

#include "frames.h"
#include "livemvs/core/options.h"
#include "livemvs/core/posterior.h"
#include "livemvs/io/video_source.h"
#include "livemvs/io/video_writer.h"
#include "livemvs/pipeline/pyramid.h"

namespace livemvs {
namespace {

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

void BM_Pyramid(benchmark::State& state) {
  const PosedFrame& frame = Sequence().frames.front();
  Pyramid pyramid;
  for (auto _ : state) pyramid.Build(frame.picture->grey, Options().levels);
  state.SetBytesProcessed(state.iterations() * frame.camera.width * frame.camera.height);
}
BENCHMARK(BM_Pyramid)->Unit(benchmark::kMillisecond)->UseRealTime();

// H.264 as a phone or webcam gives it; the decoder's threads are its own.
void BM_Decode(benchmark::State& state) {
  const BenchSequence& sequence = Sequence();
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / "livemvs_decode_bench.mp4";
  VideoWriterOptions options;
  options.width = sequence.frames.front().camera.width;
  options.height = sequence.frames.front().camera.height;
  options.crf = 20;
  VideoWriter writer(path, options);
  for (const PosedFrame& frame : sequence.frames) writer.Write(*frame.picture);
  writer.Finish();
  std::int64_t frames = 0;
  for (auto _ : state) {
    const auto source = OpenVideo(path);
    while (source->Next()) ++frames;
  }
  std::filesystem::remove(path);
  state.SetItemsProcessed(frames);
}
BENCHMARK(BM_Decode)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace livemvs
