#pragma once

#include <memory>
#include <optional>

#include "livemvs/scan/dataset_player.h"
#include "livemvs/scan/scan.h"
#include "livemvs/stream/replay.h"
#include "livemvs/tracking/board.h"
#include "scan_arguments.h"

namespace livemvs::app {

/// What a scan is made from: pictures, poses, and where surfaces are sought.
struct ScanInput {
  std::unique_ptr<DatasetPlayer> player;     ///< Of a data set with poses; or:
  std::unique_ptr<LiveSource> owned_source;  ///< Anything else.
  std::unique_ptr<PoseSource> owned_poses;
  LiveSource* source = nullptr;
  PoseSource* poses = nullptr;
  std::optional<Board> board;
  ScanSettings settings;
  bool live = false;          ///< A camera or pipe: it does not wait, and cannot be read again.
  std::int64_t expected = 0;  ///< Frames, or 0 where unknown.
};

/// Opens what the arguments name.
/// @param before  Of a scan that is resumed; null: from the start.
/// @throws Error (kBadInput) naming what is wrong with it, and the remedy.
ScanInput OpenScanInput(const ScanArguments& args, const Replay* before);

}  // namespace livemvs::app
