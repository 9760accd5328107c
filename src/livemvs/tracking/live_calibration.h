#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "livemvs/tracking/board.h"
#include "livemvs/tracking/calibrator.h"

namespace livemvs {

class LiveSource;

struct LiveCalibrationOptions {
  CalibratorOptions calibrator;
  double patience = 10;  ///< Without a picture for so long, the camera has gone for good. [s]

  void Check() const;  ///< @throws std::invalid_argument
};

/// What is to be told while it goes on. All may be empty.
struct LiveCalibrationWatch {
  std::function<bool()> stop;  ///< Asked often; true ends it with the views so far.
  /// Of the camera: lost, back.
  std::function<void(const std::string& text, bool warning)> news;
  /// After each picture. `prompt` says what to film next; empty: all is there.
  std::function<void(std::int64_t frames, int views, const std::string& prompt)> progress;
};

struct LiveCalibrationResult {
  Calibration calibration;
  std::int64_t frames = 0, with_board = 0;
  bool source_lost = false;  ///< It ended because no picture came any more.
};

/// Calibrates a camera while it films a board, saying which views are missing. Ends as soon as the
/// calibration is good and no view is missing, when pictures end, or when told to.
/// @throws what the source throws.
LiveCalibrationResult CalibrateLive(LiveSource* source,
                                    const Board& board,
                                    const LiveCalibrationOptions& options,
                                    const LiveCalibrationWatch& watch);

}  // namespace livemvs
