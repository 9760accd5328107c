#pragma once

#include <string>

#include "live_input.h"
#include "livemvs/tracking/live_calibration.h"

namespace livemvs::app {

/// Calibrates from a camera or pipe, telling on standard error what to film next, until nothing is
/// missing or the user stops it.
/// @throws Error (kBadInput) where there is no such camera or pipe.
LiveCalibrationResult CalibrateFromLive(const LiveArguments& args,
                                        const Board& board,
                                        const CalibratorOptions& options,
                                        const std::string& progress_mode);

}  // namespace livemvs::app
