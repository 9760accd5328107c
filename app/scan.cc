#include "livemvs/scan/scan.h"

#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "commands.h"
#include "interrupt.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/scan/journal_thread.h"
#include "progress.h"
#include "scan_arguments.h"
#include "scan_folder.h"
#include "scan_input.h"
#include "scan_results.h"
#include "scan_view.h"

namespace livemvs::app {
namespace {

double UnixTime() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::vector<std::uint8_t> SessionOf(const ScanArguments& args, bool resumed) {
  SessionMessage session;
  session.unix_time = UnixTime();
  nlohmann::json json = {{"program", "livemvs " LIVEMVS_VERSION},
                         {"source", args.device.empty() ? args.data.string() : args.device},
                         {"resumed", resumed},
                         {"arguments", ToJson(args)}};
  if (!args.board.empty()) json["unit"] = "m";  // a board's measures are metres
  session.json = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return Encode(session);
}

std::string NoteOf(const ScanProgress& progress) {
  std::string note;
  switch (progress.tracking) {
    case TrackingState::kSearching:
      note = progress.problem.empty() ? "searching" : progress.problem;
      break;
    case TrackingState::kTracking:
      note = "tracking";
      break;
    case TrackingState::kLost:
      note = progress.problem.empty() ? "lost" : "lost: " + progress.problem;
      break;
  }
  if (progress.dropped > 0) note += ", " + std::to_string(progress.dropped) + " dropped";
  return note;
}

ScanResult Film(const ScanArguments& args,
                const ScanFolder& folder,
                ScanInput* input,
                ScanView* view) {
  const Replay* before = folder.before ? &folder.before->replay : nullptr;
  std::unique_ptr<JournalWriter> writer = OpenJournal(folder);
  const std::vector<std::uint8_t> session = SessionOf(args, before != nullptr);
  writer->Append(RecordType::kSession, session);
  writer->Sync();  // from here on it can be resumed
  JournalThread journal(std::move(writer));
  Scan scan(input->settings, input->source, input->poses);
  if (before != nullptr) scan.Continue(*before);
  scan.AddSink(&journal);
  Progress progress(ParseProgressMode(args.progress));
  Scan::Watch watch;
  watch.stop = [view] { return Interrupted() || view->finish_asked(); };
  watch.broken = [&journal] { return journal.failure(); };
  watch.progress = [&](const ScanProgress& p) {
    progress.Show({"scan", p.frames, input->expected, p.live_seeds, p.points, NoteOf(p)});
    view->ShowProgress(p);
  };
  watch.news = [](const std::string& text, bool warning) {
    warning ? LogWarning(text) : LogInfo(text);
  };
  view->Join(session, &scan, &watch);
  ScanResult result = scan.Run(watch);
  progress.Finish();
  if (result.end == ScanEnd::kInterrupted && !Interrupted()) result.end = ScanEnd::kFinished;
  try {
    journal.Finish();
  } catch (...) {
    result.end = ScanEnd::kFailed;
    if (result.failure == nullptr) result.failure = std::current_exception();
  }
  return result;
}

// A result made of the journal alone.
ScanResult FromJournal(const Replay& replay) {
  ScanResult result;
  result.points = replay.Points();
  result.frames = replay.frames();
  result.camera = replay.camera();
  return result;
}

// Where to look, for the statistics and the messages of a scan that is only finished.
ScanSettings SettingsOf(const ScanArguments& args, const Replay& replay) {
  ScanSettings settings;
  settings.method = MakeOptions(args.method);
  if (replay.scene()) {
    settings.range.box = replay.scene()->box;
    settings.range.near = replay.scene()->near;
    settings.range.far = replay.scene()->far;
    settings.range.origin = replay.scene()->origin;
  }
  return settings;
}

void ReportEnd(const ScanFolder& folder, const ScanInput& input, const ScanResult& result) {
  const CaptureStatistics& c = result.capture;
  if (result.end == ScanEnd::kSourceLost) LogWarning("the camera did not come back");
  const std::int64_t left_out = c.out_of_order + c.duplicates + c.other_size;
  if (left_out > 0) {
    LogWarning(std::to_string(left_out) + " pictures were left out: " +
               std::to_string(c.out_of_order) + " out of order, " + std::to_string(c.duplicates) +
               " repeated, " + std::to_string(c.other_size) + " of another size");
  }
  if (c.dropped > 0) {
    LogWarning(std::to_string(c.dropped) +
               " pictures were dropped, because the engine was late; fewer --seeds keep pace");
  }
  if (result.failure != nullptr) {
    LogWarning(
        "the scan was stopped; what it has is kept, and can be continued: livemvs scan "
        "--resume " +
        folder.path.string());
    std::rethrow_exception(result.failure);
  }
  // Who films ends the scan so; a recording has an end of its own.
  if (result.end == ScanEnd::kInterrupted && !input.live) {
    LogInfo("interrupted; go on with: livemvs scan --resume " + folder.path.string());
    throw CLI::RuntimeError(kExitInterrupted);
  }
}

// A scan in which the camera was never found is no scan.
void RequirePoses(const ScanResult& result, const std::string& problem) {
  for (const FrameMessage& frame : result.frames) {
    if (frame.cam_from_world) return;
  }
  if (result.frames.empty() || result.failure != nullptr) return;
  throw BadInput("no pose was found in any of " + std::to_string(result.frames.size()) +
                 " pictures: " + (problem.empty() ? "board not seen" : problem) +
                 "; see that the whole sheet is in the picture, sharp, and the one that --board "
                 "describes");
}

void RunScan(ScanArguments args) {
  CheckScanArguments(args);
  MakeOptions(args.method);  // wrong ones are told before any work
  ParseProgressMode(args.progress);
  const std::optional<tbb::global_control> thread_limit = LimitThreads(args.method.threads);
  CatchInterrupts();
  const ScanFolder folder = OpenScanFolder(&args);
  const Replay* before = folder.before ? &folder.before->replay : nullptr;
  const bool ended =
      before != nullptr && before->end() && before->end()->reason == EndMessage::kFinished;
  if (args.finish || ended) {
    ScanResult result = FromJournal(*before);
    if (WriteScanResults(folder.path, args, SettingsOf(args, *before), &result)) {
      throw CLI::RuntimeError(kExitInterrupted);
    }
    return;
  }
  if (before == nullptr) CheckScanFolder(folder.path);
  ScanInput input = OpenScanInput(args, before);
  if (before == nullptr) {
    MakeScanFolder(folder.path);
    if (input.board) WriteBoard(folder.path / kBoardName, *input.board);
  }
  ScanView view(args, folder, input);
  ScanResult result = Film(args, folder, &input, &view);
  view.End(result);
  RequirePoses(result, result.tracking_problem);
  bool mesh_interrupted = false;
  try {
    mesh_interrupted = WriteScanResults(folder.path, args, input.settings, &result);
  } catch (const Error&) {
    if (result.failure == nullptr) throw;
  }
  ReportEnd(folder, input, result);
  if (mesh_interrupted) throw CLI::RuntimeError(kExitInterrupted);
  view.Linger();
}

}  // namespace

void AddScanCommand(CLI::App& app) {
  auto args = std::make_shared<ScanArguments>();
  CLI::App* command = app.add_subcommand(
      "scan", "Film an object on a printed board, or play a recording, and get its model");
  AddScanOptions(command, args.get());
  command->footer(
      "Examples:\n"
      "  livemvs scan --camera 0 --board board.json -o mug\n"
      "  livemvs scan --data video.mp4 --board board.json --calibration camera.yaml -o mug\n"
      "  livemvs scan --data video.mp4 --board board.json --realtime -o mug\n"
      "  livemvs scan --data folder-with-poses/ -o room\n"
      "  livemvs scan --camera 0 --board board.json --view -o mug\n"
      "  livemvs scan --resume mug                  go on after an interruption\n"
      "  livemvs scan --resume mug --finish         write what was recorded before it\n\n"
      "The folder gets cloud.ply, the mesh model.glb, poses.txt, camera.yaml, statistics.json, "
      "and\n"
      "journal.lmv, which is written while filming: whatever happens, at most the last second is\n"
      "lost. Ctrl-C while the mesh is made leaves it out; livemvs mesh DIR makes it later.\n\n"
      "Exit codes: 0 done (Ctrl-C ends filming), 1 failed, 2 usage, 3 bad input, 4 out of\n"
      "resources (the scan so far is kept), 130 interrupted: a recording (--resume goes on), or "
      "the\n"
      "mesh.");
  command->callback([args] { RunScan(*args); });
}

}  // namespace livemvs::app
