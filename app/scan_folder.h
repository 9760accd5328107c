#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "livemvs/stream/journal.h"
#include "livemvs/stream/replay.h"
#include "scan_arguments.h"

namespace livemvs::app {

/// A scan's folder with what is known of it.
struct ScanFolder {
  std::filesystem::path path;
  std::optional<JournalContents> before;  ///< Where the scan is resumed.
};

/// Opens the folder of the scan to resume, and takes the arguments from it.
ScanFolder OpenScanFolder(ScanArguments* args);

/// An older scan is not touched; what was cut off before its first record is none.
/// @throws Error (kBadInput) where there is a scan
void CheckScanFolder(const std::filesystem::path& folder);

/// @throws Error (kBadInput) where it cannot be
void MakeScanFolder(const std::filesystem::path& folder);

/// A journal to begin, or one to go on with.
std::unique_ptr<JournalWriter> OpenJournal(const ScanFolder& folder);

}  // namespace livemvs::app
