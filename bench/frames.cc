#include "frames.h"

#include <cstdlib>

#include "livemvs/io/dataset.h"
#include "livemvs/synth/sequence.h"

namespace livemvs {
namespace {

BenchSequence ReadSequence(const char* folder) {
  DatasetOptions options;
  options.data = folder;
  const auto dataset = OpenDataset(options);
  std::vector<PosedCamera> cameras;
  for (const DatasetView& view : dataset->views()) {
    cameras.push_back({view.camera, view.cam_from_world});
  }
  BenchSequence sequence;
  sequence.range = DeriveRange(cameras, dataset->sparse_points());
  while (auto frame = dataset->Next()) sequence.frames.push_back(std::move(*frame));
  return sequence;
}

BenchSequence RenderStillLife() {
  constexpr int kFrames = 40;
  const SyntheticScene scene({.name = "table", .seed = 1, .shadows = false});
  SequenceOptions options;
  options.path = DefaultPath("table");
  options.path.arc_deg *= kFrames / 180.0;
  options.path.frames = kFrames;
  options.samples_per_pixel = 1;
  options.noise_sigma = 1.5;
  options.ground_truth = false;
  BenchSequence sequence;
  for (SyntheticFrame& f : RenderSequence(scene, options)) {
    sequence.frames.push_back(std::move(f.frame));
  }
  sequence.range.near = 0.2;
  sequence.range.far = 1.2;
  return sequence;
}

}  // namespace

const BenchSequence& Sequence() {
  static const BenchSequence sequence = [] {
    const char* folder = std::getenv("LIVEMVS_BENCH_DATA");
    return folder != nullptr && *folder != 0 ? ReadSequence(folder) : RenderStillLife();
  }();
  return sequence;
}

}  // namespace livemvs
