#include <oneapi/tbb/global_control.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "commands.h"
#include "dataset_options.h"
#include "interrupt.h"
#include "live_view.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/atomic_file.h"
#include "livemvs/io/dataset.h"
#include "livemvs/io/ply.h"
#include "livemvs/io/prefetcher.h"
#include "livemvs/io/seed_trace.h"
#include "livemvs/map/finish_cloud.h"
#include "livemvs/map/normals.h"
#include "livemvs/pipeline/reconstructor.h"
#include "livemvs/pipeline/scene_range.h"
#include "livemvs/pipeline/search_mode.h"
#include "output_check.h"
#include "progress.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct RunArguments {
  DatasetOptions dataset;
  fs::path output;
  fs::path stats;
  fs::path trace;
  std::string preset = "default";
  std::vector<std::string> settings;
  std::vector<double> box;
  double near = 0;
  double far = 0;
  std::string search;
  int seeds = 0;
  int threads = 0;
  std::string progress = "auto";
  bool ray_normals = false;
  bool real_time = false;
  ViewOptions view;
};

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Options MakeOptions(const RunArguments& args) {
  Options options = OptionsFromPreset(args.preset);
  for (const std::string& setting : args.settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("--set " + setting + ": must be NAME=VALUE");
    }
    SetOption(&options, setting.substr(0, equals), setting.substr(equals + 1));
  }
  if (args.seeds > 0) options.max_seeds = args.seeds;
  if (args.threads > 0) options.threads = args.threads;
  if (!args.search.empty()) SetOption(&options, "search", args.search);
  options.Check();
  return options;
}

std::vector<CameraPose> CamerasOf(const Dataset& dataset) {
  std::vector<CameraPose> cameras;
  for (const DatasetView& view : dataset.views()) {
    cameras.push_back({view.camera, view.cam_from_world});
  }
  return cameras;
}

SceneRange RangeOf(const RunArguments& args, const Dataset& dataset) {
  const std::vector<CameraPose> cameras = CamerasOf(dataset);
  SceneRange range;
  if (!args.box.empty()) {
    Box box;
    box.min = {args.box[0], args.box[1], args.box[2]};
    box.max = {args.box[3], args.box[4], args.box[5]};
    range.box = box;
    range.near = 1;
    range.far = 2;
    range.Check();
    range = RangeOfBox(box, cameras);
  } else if (args.near > 0 && args.far > 0) {
    range.origin = "--near and --far";
  } else if (dataset.box()) {
    range = RangeOfBox(*dataset.box(), cameras);
    range.origin = "the data set's box";
  } else {
    range = DeriveRange(cameras, dataset.sparse_points());
  }
  if (args.near > 0) range.near = args.near;
  if (args.far > 0) range.far = args.far;
  range.Check();
  return range;
}

// An empty range is bad input, wherever it comes from.
SceneRange MakeRange(const RunArguments& args, const Dataset& dataset) {
  try {
    return RangeOf(args, dataset);
  } catch (const std::invalid_argument& e) {
    throw BadInput(e.what());
  }
}

std::string Describe(const SceneRange& range) {
  char text[256];
  std::snprintf(text, sizeof(text), "depths %.4g to %.4g", range.near, range.far);
  std::string description = text;
  if (range.box) {
    const Box& b = *range.box;
    std::snprintf(text,
                  sizeof(text),
                  " in the box (%.4g %.4g %.4g) to (%.4g %.4g %.4g)",
                  b.min.x(),
                  b.min.y(),
                  b.min.z(),
                  b.max.x(),
                  b.max.y(),
                  b.max.z());
    description += text;
  }
  return description + ", from " + range.origin;
}

nlohmann::json StatisticsJson(const RunArguments& args,
                              const Options& options,
                              const SceneRange& range,
                              const Dataset& dataset,
                              const Dataset::Statistics& frames,
                              const Reconstructor& reconstructor,
                              std::size_t points,
                              double loop_seconds,
                              double total_seconds) {
  const ReconstructionStatistics& s = reconstructor.statistics();
  nlohmann::json json;
  json["data"] = dataset.description();
  json["preset"] = args.preset;
  VisitOptions(options, [&](const char* name, const auto&) {
    json["options"][name] = GetOption(options, name);
  });
  json["range"] = Describe(range);
  json["backend"] = reconstructor.backend_name();
  json["frames"] = {{"decoded", frames.decoded}, {"skipped", frames.skipped}, {"used", s.frames}};
  json["seeds"] = {{"spawned", s.seeds_spawned},
                   {"converged", s.seeds_converged},
                   {"alive", reconstructor.live_seeds()},
                   {"rejected",
                    {{"outlier", s.rejected_outlier},
                     {"aged", s.rejected_aged},
                     {"unseen", s.rejected_unseen},
                     {"left_interval", s.rejected_left_interval}}}};
  json["updates"] = {
      {"total", s.updates.total()},
      {"matched", s.updates.matched},
      {"no_information", s.updates.no_information},
      {"out_of_view", s.updates.out_of_view},
      {"mismatched", s.updates.mismatched},
      {"per_second",
       s.update_seconds > 0 ? static_cast<double>(s.updates.total()) / s.update_seconds : 0}};
  json["seconds"] = {{"spawn", s.spawn_seconds},
                     {"update", s.update_seconds},
                     {"collect", s.collect_seconds},
                     {"loop", loop_seconds},
                     {"total", total_seconds}};
  json["frames_per_second"] = loop_seconds > 0 ? static_cast<double>(s.frames) / loop_seconds : 0;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  json["peak_memory_mb"] = static_cast<double>(usage.ru_maxrss) / 1024;
  json["cpu_seconds"] = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                        1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  json["points"] = points;
  return json;
}

// Is told of each frame and what converged in it; false ends the run there.
using FrameHook = std::function<bool(const PosedFrame&, std::span<const Point>)>;

// Feeds all frames. Where something fails on the way, what was reconstructed is kept and the
// failure returned, to be reported once it is written.
std::exception_ptr Reconstruct(Prefetcher* frames,
                               std::int64_t frame_count,
                               Progress* progress,
                               Reconstructor* reconstructor,
                               const FrameHook& after_frame) {
  try {
    while (const std::optional<PosedFrame> frame = frames->Next(Interrupted)) {
      const std::span<const Point> converged = reconstructor->AddFrame(*frame);
      if (!after_frame(*frame, converged)) break;
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

// Waits until the frame's time has come, so that a recording plays as it was filmed.
class Pacer {
 public:
  void Wait(double timestamp) {
    if (!first_) first_ = timestamp;
    const auto due = start_ + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(timestamp - *first_));
    while (Clock::now() < due && !Interrupted()) {
      std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
    }
  }

 private:
  Clock::time_point start_ = Clock::now();
  std::optional<double> first_;
};

// The viewer of a run, which has begun its stream.
std::unique_ptr<LiveView> OpenView(const RunArguments& args,
                                   const Options& options,
                                   const SceneRange& range,
                                   const Dataset& dataset) {
  if (!args.view.view) return nullptr;
  viewer::FeedOptions feed;
  feed.engine = options;
  auto view = std::make_unique<LiveView>(args.view, args.dataset.data.filename().string(), feed);
  SessionMessage session;
  session.json =
      nlohmann::json(
          {{"program", "livemvs run"}, {"source", dataset.description()}, {"preset", args.preset}})
          .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  view->feed().Begin(session, SceneMessage{range.box, range.near, range.far, range.origin});
  return view;
}

FrameHook MakeFrameHook(const RunArguments& args,
                        std::int64_t frame_count,
                        const Reconstructor& reconstructor,
                        LiveView* view) {
  auto pacer = std::make_shared<Pacer>();
  return [&args, frame_count, &reconstructor, view, pacer](const PosedFrame& frame,
                                                           std::span<const Point> converged) {
    if (args.real_time) pacer->Wait(frame.timestamp);
    if (view == nullptr) return true;
    viewer::LiveCounts counts;
    counts.frames = reconstructor.statistics().frames;
    counts.frames_total = frame_count;
    counts.seeds = static_cast<std::int64_t>(reconstructor.live_seeds());
    counts.points = static_cast<std::int64_t>(reconstructor.points().size());
    view->feed().AddFrame(frame, converged, counts, &reconstructor.pool());
    view->WaitWhilePaused(Interrupted);
    return !view->finish_asked();
  };
}

// Tells the viewer how the run ended; it stays open until it is told to end.
void CloseView(const Reconstructor& reconstructor,
               std::size_t points,
               std::exception_ptr failure,
               LiveView* view) {
  if (view == nullptr) return;
  EndMessage end;
  end.frames = reconstructor.statistics().frames;
  end.points = static_cast<std::int64_t>(points);
  if (Interrupted()) end.reason = EndMessage::kInterrupted;
  if (failure) end.reason = EndMessage::kFailed;
  view->feed().End(end);
  if (!failure) view->Linger(Interrupted);
}

// Writes what became of each seed, where that was asked for.
class TraceObserver : public SeedObserver {
 public:
  explicit TraceObserver(const fs::path& path) : writer_(path) {}
  void OnSeed(const SeedRecord& record) override { writer_.Write(record); }
  void Finish() { writer_.Finish(); }

 private:
  SeedTraceWriter writer_;
};

void ExplainEmptyCloud(const ReconstructionStatistics& s) {
  if (s.seeds_converged > 0) {
    LogWarning(
        "no point is left: too few of them lie on a surface with others; try --set "
        "min_support=0");
    return;
  }
  std::string reason = "too few frames";
  if (s.seeds_spawned == 0) {
    reason = "no pixel has texture within the range: check --box or --near and --far";
  } else if (s.updates.no_information >= s.updates.total() * 9 / 10) {
    reason = "the camera hardly moves, or its pictures are blurred";
  } else if (s.updates.out_of_view > s.updates.total() / 2) {
    reason =
        "what one frame shows, the next do not: check the poses, their convention and the range";
  } else if (s.updates.mismatched > s.updates.matched) {
    reason = "patches are not found where the poses say: check poses, convention and calibration";
  }
  LogWarning("no point converged; likely because: " + reason);
}

// Settles what depends on the data, and says so.
Options FitToData(const Options& options, const Dataset& dataset, const SceneRange& range) {
  LogInfo("looking for surfaces at " + Describe(range));
  Options fitted = ResolveSearch(CamerasOf(dataset), range, options);
  LogInfo(fitted.search == Search::kFull
              ? "searching whole epipolar lines: the steps between frames are wide"
              : "searching near the prediction: the steps between frames are small");
  return fitted;
}

// Estimates normals where they are wanted, and writes the cloud.
void WriteCloud(const RunArguments& args, PointCloud* cloud) {
  const bool estimate_normals = !args.ray_normals && !Interrupted();
  if (estimate_normals) EstimateNormals(*cloud);
  WritePly(args.output,
           *cloud,
           estimate_normals ? "of the plane through the 16 nearest points, on the camera's side"
                            : "towards the camera that planted the seed");
}

void WriteStatistics(const fs::path& path, const nlohmann::json& statistics) {
  AtomicFile file(path);
  file.Write(statistics.dump(2) + "\n");
  file.Commit();
  std::printf("%s\n", fs::absolute(path).c_str());
}

// All that runs in parallel uses as many threads, normals too.
std::optional<tbb::global_control> LimitThreads(int threads) {
  if (threads <= 0) return std::nullopt;
  return std::optional<tbb::global_control>(std::in_place,
                                            tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
}

void Run(const RunArguments& args) {
  const Clock::time_point start = Clock::now();
  MakeOptions(args);  // wrong ones are told before any work
  CheckOutputs({{args.output, "the cloud", "a point cloud", "ply"},
                {args.stats, "the statistics", "", ""},
                {args.trace, "the trace", "a seed trace", kSeedTraceMagic}},
               {args.dataset.data, args.dataset.poses, args.dataset.camera});
  const std::optional<tbb::global_control> thread_limit = LimitThreads(args.threads);
  const ProgressMode progress_mode = ParseProgressMode(args.progress);
  CatchInterrupts();
  DatasetOptions dataset_options = args.dataset;
  dataset_options.cancelled = Interrupted;
  const std::unique_ptr<Dataset> dataset = OpenDataset(dataset_options);
  const SceneRange range = MakeRange(args, *dataset);
  const Options options = FitToData(MakeOptions(args), *dataset, range);

  Reconstructor reconstructor(options, range);
  const std::unique_ptr<LiveView> view = OpenView(args, options, range, *dataset);
  std::optional<TraceObserver> trace;
  if (!args.trace.empty()) reconstructor.SetObserver(&trace.emplace(args.trace));
  Progress progress(progress_mode);
  const Clock::time_point loop_start = Clock::now();
  Dataset::Statistics frame_statistics;
  std::exception_ptr failure;
  {
    Prefetcher frames(dataset.get());
    const auto frame_count = static_cast<std::int64_t>(dataset->views().size());
    failure = Reconstruct(&frames,
                          frame_count,
                          &progress,
                          &reconstructor,
                          MakeFrameHook(args, frame_count, reconstructor, view.get()));
    frame_statistics = frames.statistics();
  }
  progress.Finish();
  const double loop_seconds = SecondsSince(loop_start);

  PointCloud cloud = reconstructor.TakePoints();
  const FinishedCloud finished = FinishCloud(options, &cloud);
  if (cloud.empty()) ExplainEmptyCloud(reconstructor.statistics());
  WriteCloud(args, &cloud);
  nlohmann::json statistics = StatisticsJson(args,
                                             options,
                                             range,
                                             *dataset,
                                             frame_statistics,
                                             reconstructor,
                                             cloud.size(),
                                             loop_seconds,
                                             SecondsSince(start));
  statistics["removed"] = {{"superseded", finished.superseded},
                           {"unsupported", finished.unsupported}};
  std::printf("%zu points from %lld frames in %.1f s (%.1f frames/s)\n",
              cloud.size(),
              static_cast<long long>(reconstructor.statistics().frames),
              SecondsSince(start),
              statistics["frames_per_second"].get<double>());
  std::printf("%s\n", fs::absolute(args.output).c_str());
  if (!args.stats.empty()) WriteStatistics(args.stats, statistics);
  const bool interrupted = Interrupted();
  CloseView(reconstructor, cloud.size(), failure, view.get());
  if (failure) std::rethrow_exception(failure);
  if (trace) {
    reconstructor.ReportLiveSeeds();
    trace->Finish();
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
  command->add_option("--preset", args->preset, "default, or paper: the method as published");
  command->add_option("--box", args->box, "Reconstruct inside of x0 y0 z0 x1 y1 z1 [scene units]")
      ->expected(6);
  command->add_option("--near", args->near, "Least depth [scene units]")
      ->check(CLI::PositiveNumber);
  command->add_option("--far", args->far, "Largest depth [scene units]")
      ->check(CLI::PositiveNumber);
  command->add_option(
      "--search", args->search, "window, full (for wide steps between frames), or auto");
  command->add_option("--seeds", args->seeds, "Seeds kept alive (250000)")
      ->check(CLI::PositiveNumber);
  command->add_option("--threads", args->threads, "Worker threads (all cores)")
      ->check(CLI::PositiveNumber);
  command->add_option("--set", args->settings, "Any option of the method, NAME=VALUE; repeatable");
  command->add_flag("--ray-normals",
                    args->ray_normals,
                    "Write viewing directions as normals, instead of estimating planes");
  command->add_flag("--real-time", args->real_time, "Take the frames as fast as they were filmed");
  AddViewOptions(command, &args->view);
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
