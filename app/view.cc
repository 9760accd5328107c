#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "commands.h"
#include "interrupt.h"
#include "live_view.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/stream/journal.h"
#include "livemvs/stream/messages.h"
#include "livemvs/stream/point_codec.h"
#include "model_input.h"
#include "viewer/mesh_record.h"

namespace livemvs::app {
namespace {

namespace fs = std::filesystem;
using viewer::StreamLog;

struct ViewArguments {
  fs::path input;
  PageOptions view;
};

constexpr auto kPoll = std::chrono::milliseconds(30);

// A folder stands for the journal in it.
fs::path FileOf(const fs::path& input) {
  std::error_code ignored;
  if (!fs::is_directory(input, ignored)) return input;
  const fs::path journal = input / "journal.lmv";
  if (fs::exists(journal, ignored)) return journal;
  throw BadInput(input.string() +
                 ": holds no journal.lmv; name a scan's folder, or a .ply or .glb file");
}

void PublishModel(const fs::path& path, StreamLog* log) {
  const PlyContents ply = ReadModel(path);
  if (ply.cloud.empty()) throw BadInput(path.string() + ": holds no vertex");
  SessionMessage session;
  session.json = nlohmann::json({{"program", "livemvs view"}, {"source", path.filename().string()}})
                     .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  log->Append(RecordType::kSession, Encode(session));
  EndMessage end;
  if (!ply.faces.empty()) {
    for (const auto& payload : viewer::EncodeMesh(ply)) log->Append(viewer::kRecordMesh, payload);
  } else {
    std::uint32_t first_id = 0;
    for (const PointCloud& group : GroupForStream(ply.cloud)) {
      log->Append(RecordType::kPoints, EncodePoints(0, first_id, group));
      first_id += static_cast<std::uint32_t>(group.size());
    }
    end.points = first_id;
  }
  log->Append(RecordType::kEnd, Encode(end));
}

// Hands on what a journal holds, and what is added to it, until interrupted. Records keep their
// numbers, because both sides count from 0.
void FollowJournal(JournalReader* journal, const fs::path& path, StreamLog* log) {
  bool told = false;
  while (!Interrupted()) {
    while (const std::optional<Record> record = journal->Next()) {
      log->Append(record->type, record->payload);
    }
    if (journal->tail() == JournalReader::Tail::kCorrupt && !told) {
      told = true;
      LogWarning(path.string() + ": what follows byte " + std::to_string(journal->valid_bytes()) +
                 " is damaged and not shown");
    }
    std::this_thread::sleep_for(kPoll);
  }
}

void View(const ViewArguments& args) {
  const fs::path file = FileOf(args.input);
  StreamLog log;
  std::unique_ptr<JournalReader> journal;
  if (IsModelName(file)) {
    PublishModel(file, &log);
  } else {
    journal = std::make_unique<JournalReader>(file);
  }
  CatchInterrupts();
  viewer::Server server(&log, MakeServerOptions(args.view, file.filename().string()));
  const OpenedPage page(server, args.view);
  if (journal) {
    FollowJournal(journal.get(), file, &log);
  } else {
    while (!Interrupted()) std::this_thread::sleep_for(kPoll);
  }
}

}  // namespace

void AddViewCommand(CLI::App& app) {
  auto args = std::make_shared<ViewArguments>();
  CLI::App* command = app.add_subcommand("view", "Show a cloud, a mesh or a scan in a browser");
  command
      ->add_option(
          "IN", args->input, "Cloud or mesh (.ply, .ply.gz, .glb), journal, or folder of a scan")
      ->required();
  AddPageOptions(command, &args->view, false);
  command->footer(
      "A scan that is still running is followed. It serves until Ctrl-C.\n\n"
      "Examples:\n"
      "  livemvs view scan.ply\n"
      "  livemvs view scans/vase --no-browser\n"
      "  livemvs view scans/vase/model.glb\n"
      "  livemvs view mesh.ply.gz --listen 0.0.0.0      (for a phone in the same network)");
  command->callback([args] { View(*args); });
}

}  // namespace livemvs::app
