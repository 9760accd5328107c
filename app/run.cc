
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cloud_output.h"
#include "commands.h"
#include "dataset_options.h"
#include "interrupt.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/prefetcher.h"
#include "livemvs/io/seed_trace.h"
#include "livemvs/pipeline/reconstructor.h"
#include "method_options.h"
#include "output_check.h"
#include "progress.h"
#include "run_view.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct RunArguments {
  DatasetOptions dataset;
  MethodArguments method;
  fs::path output;
  fs::path stats;
  fs::path trace;
  std::string progress = "auto";
  bool ray_normals = false;
  double speed = 0;  // of the recording; 0: as fast as it goes
  PageOptions view;
};

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

nlohmann::json StatisticsJson(const RunArguments& args,
                              const Options& options,
                              const SceneRange& range,
                              const Dataset& dataset,
                              const Dataset::Statistics& frames,
                              const Reconstructor& reconstructor) {
  const ReconstructionStatistics& s = reconstructor.statistics();
  nlohmann::json json = ReconstructionJson(options, s, reconstructor.live_seeds());
  json["data"] = dataset.description();
  json["preset"] = args.method.preset;
  json["range"] = Describe(range);
  json["backend"] = reconstructor.backend_name();
  json["frames"] = {{"decoded", frames.decoded}, {"skipped", frames.skipped}, {"used", s.frames}};
  return json;
}

// Feeds all frames. Where something fails on the way, what was reconstructed is kept and the
// failure returned, to be reported once it is written.
std::exception_ptr Reconstruct(Prefetcher* frames,
                               std::int64_t frame_count,
                               Progress* progress,
                               Reconstructor* reconstructor,
                               RunView* view) {
  try {
    while (const std::optional<PosedFrame> frame = frames->Next(Interrupted)) {
      const std::span<const Point> converged = reconstructor->AddFrame(*frame);
      if (!view->Show(*frame, converged, frame_count, *reconstructor)) break;
      progress->Show({"reconstruct",
                      reconstructor->statistics().frames,
                      frame_count,
                      static_cast<std::int64_t>(reconstructor->live_seeds()),
                      static_cast<std::int64_t>(reconstructor->points().size())});
    }
  } catch (...) {
    if (reconstructor->points().empty()) throw;
    return std::current_exception();
  }
  return nullptr;
}

// Writes what became of each seed, where that was asked for.
class TraceObserver : public SeedObserver {
 public:
  explicit TraceObserver(const fs::path& path) : writer_(path) {}
  void OnSeed(const SeedRecord& record) override {
    if (record.fate == Fate::kConverged) converged_.push_back(writer_.count());
    writer_.Write(record);
  }
  // `kept`: of the points, one for each seed that converged, those that are in the cloud;
  // ascending.
  void Finish(std::span<const std::uint32_t> kept) {
    auto next = kept.begin();
    for (std::size_t i = 0; i < converged_.size(); ++i) {
      if (next != kept.end() && *next == i) {
        ++next;
      } else {
        writer_.SetFate(converged_[i], Fate::kTakenOut);
      }
    }
    writer_.Finish();
  }

 private:
  SeedTraceWriter writer_;
  std::vector<std::uint64_t> converged_;  // their places in the trace
};

// Finishes and writes the cloud; says so in the statistics and on standard output.
FinishedCloud WriteResults(const RunArguments& args,
                           const Options& options,
                           const SceneRange& range,
                           Reconstructor* reconstructor,
                           nlohmann::json* statistics) {
  PointCloud cloud = reconstructor->TakePoints();
  FinishedCloud finished =
      FinishPoints(options, range, reconstructor->statistics(), &cloud, statistics);
  WriteCloud(args.output, !args.ray_normals && !Interrupted(), &cloud);
  return finished;
}

void Run(const RunArguments& args) {
  const Clock::time_point start = Clock::now();
  MakeOptions(args.method);  // wrong ones are told before any work
  CheckOutputs({{args.output, "the cloud", "a point cloud", "ply"},
                {args.stats, "the statistics", "", ""},
                {args.trace, "the trace", "a seed trace", kSeedTraceMagic}},
               {args.dataset.data, args.dataset.poses, args.dataset.camera});
  const std::optional<tbb::global_control> thread_limit = LimitThreads(args.method.threads);
  const ProgressMode progress_mode = ParseProgressMode(args.progress);
  CatchInterrupts();
  DatasetOptions dataset_options = args.dataset;
  dataset_options.cancelled = Interrupted;
  const std::unique_ptr<Dataset> dataset = OpenDataset(dataset_options);
  const SceneRange range = RangeOf(args.method, *dataset);
  const Options options = FitToData(MakeOptions(args.method), *dataset, range);

  Reconstructor reconstructor(options, range);
  RunView view({args.view, args.speed, args.dataset.data.filename().string()},
               options,
               range,
               dataset->description());
  std::optional<TraceObserver> trace;
  if (!args.trace.empty()) reconstructor.SetObserver(&trace.emplace(args.trace));
  Progress progress(progress_mode);
  const Clock::time_point loop_start = Clock::now();
  Dataset::Statistics frame_statistics;
  std::exception_ptr failure;
  {
    Prefetcher frames(dataset.get());
    failure = Reconstruct(&frames,
                          static_cast<std::int64_t>(dataset->views().size()),
                          &progress,
                          &reconstructor,
                          &view);
    frame_statistics = frames.statistics();
  }
  progress.Finish();
  const double loop_seconds = SecondsSince(loop_start);
  const auto frames = static_cast<double>(reconstructor.statistics().frames);
  const double rate = loop_seconds > 0 ? frames / loop_seconds : 0;

  nlohmann::json statistics =
      StatisticsJson(args, options, range, *dataset, frame_statistics, reconstructor);
  const FinishedCloud finished = WriteResults(args, options, range, &reconstructor, &statistics);
  const double total_seconds = SecondsSince(start);
  statistics["frames_per_second"] = rate;
  statistics["seconds"]["loop"] = loop_seconds;
  statistics["seconds"]["total"] = total_seconds;
  AddResources(&statistics);
  std::printf("%zu points from %.0f frames in %.1f s (%.1f frames/s)\n",
              statistics["points"].get<std::size_t>(),
              frames,
              total_seconds,
              rate);
  std::printf("%s\n", fs::absolute(args.output).c_str());
  if (!args.stats.empty()) WriteStatistics(args.stats, statistics);
  const bool interrupted = Interrupted();
  view.Close(reconstructor.statistics().frames, statistics["points"].get<std::int64_t>(), failure);
  if (failure) std::rethrow_exception(failure);
  if (trace) {
    reconstructor.ReportLiveSeeds();
    trace->Finish(finished.kept);
    std::printf("%s\n", fs::absolute(args.trace).c_str());
  }
  if (interrupted) throw CLI::RuntimeError(kExitInterrupted);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  auto args = std::make_shared<RunArguments>();
  CLI::App* command =
      app.add_subcommand("run", "Reconstruct a point cloud from posed video or images");
  AddDatasetOptions(command, &args->dataset);
  command->add_option("-o,--output", args->output, "Point cloud to write (PLY)")->required();
  command->add_option("--stats", args->stats, "Statistics of the run to write (JSON)");
  command->add_option(
      "--trace", args->trace, "What became of each seed, to write for 'livemvs eval --trace'");
  AddMethodOptions(command, &args->method);
  command->add_flag("--ray-normals",
                    args->ray_normals,
                    "Write viewing directions as normals, instead of estimating planes");
  command->add_option("--speed", args->speed, "Take the frames at so many times their own pace")
      ->check(CLI::PositiveNumber);
  command->add_flag_callback(
      "--realtime", [args] { args->speed = 1; }, "Take the frames as fast as they were filmed");
  AddPageOptions(command, &args->view);
  command->add_option("--progress", args->progress, "auto, line, json or none");
  command->footer(
      "Examples:\n"
      "  livemvs run --data scan/ -o scan.ply\n"
      "  livemvs run --data video.mp4 --poses poses.txt --camera camera.yaml -o scan.ply\n"
      "  livemvs run --data scan/ --box -0.2 -0.2 0 0.2 0.2 0.3 --stats scan.json -o scan.ply\n"
      "  livemvs run --data scan/ --preset paper -o paper.ply\n"
      "  livemvs run --data scan/ --view -o scan.ply\n"
      "  livemvs run --data photos/ --search full -o photos.ply\n"
      "  livemvs run --data scene/ --trace scene.trace -o scene.ply    (see 'livemvs eval "
      "--help')\n\n"
      "Exit codes: 0 done, 1 failed, 2 usage, 3 bad input, 4 out of resources, 130 interrupted\n"
      "(the cloud so far is written).");
  command->callback([args] { Run(*args); });
}

}  // namespace livemvs::app
