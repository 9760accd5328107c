#include "scan_folder.h"

#include <string>
#include <system_error>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "scan_results.h"

namespace livemvs::app {

namespace fs = std::filesystem;

void CheckScanFolder(const fs::path& folder) {
  const fs::path path = folder / kJournalName;
  std::error_code error;
  if (!fs::exists(path, error)) return;
  bool begun = true;
  {
    JournalReader journal(path);
    begun = journal.Next().has_value() || journal.tail() == JournalReader::Tail::kCorrupt;
  }
  if (!begun) {
    fs::remove(path, error);
    return;
  }
  throw BadInput(folder.string() + ": holds a scan already; go on with it by --resume " +
                 folder.string() + ", or name another folder");
}

void MakeScanFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw BadInput(folder.string() + ": cannot be made: " + error.message());
  }
}

ScanFolder OpenScanFolder(ScanArguments* args) {
  ScanFolder folder{args->output, std::nullopt};
  if (args->resume.empty()) return folder;
  folder.path = args->resume;
  const fs::path journal = folder.path / kJournalName;
  folder.before = ReadJournal(journal);
  const MethodArguments told = args->method;
  FromJson(folder.before->replay.sessions().front().json, journal.string(), args);
  args->method.threads = told.threads;
  args->realtime = false;  // what was missed is not live any more
  if (!args->board.empty()) args->board = folder.path / kBoardName;
  LogInfo(folder.path.string() + ": " + std::to_string(folder.before->replay.frames().size()) +
          " frames and " + std::to_string(folder.before->replay.Points().size()) +
          " points are there");
  if (folder.before->tail != JournalReader::Tail::kClean) {
    LogInfo(journal.string() + ": its end was cut off, within the last second of the scan");
  }
  return folder;
}

std::unique_ptr<JournalWriter> OpenJournal(const ScanFolder& folder) {
  const fs::path path = folder.path / kJournalName;
  if (!folder.before) return std::make_unique<JournalWriter>(path);
  return std::make_unique<JournalWriter>(
      path, folder.before->valid_bytes, folder.before->next_sequence);
}

}  // namespace livemvs::app
