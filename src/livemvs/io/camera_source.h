#pragma once

#include <memory>
#include <string>

#include "livemvs/io/camera_modes.h"
#include "livemvs/io/live_source.h"

namespace livemvs {

struct CameraOptions {
  ModeWish mode;
  /// After a second, exposure, focus and white balance stay as they are, where the driver can.
  bool lock_controls = false;
};

/// "0" is /dev/video0; anything else is a path.
std::string CameraPath(const std::string& camera);

/// Opens a camera. It counts as lost as soon as the driver says so, or when it has sent nothing for
/// 2 s; then it is opened anew as soon as it is back, wherever it is plugged in, in the same mode.
/// @throws Error (kBadInput) naming the device and the remedy, where there is no such camera, it is
/// in use, or has no such mode.
std::unique_ptr<LiveSource> OpenCamera(const std::string& camera, const CameraOptions& options);
std::unique_ptr<LiveSource> OpenCamera(const std::string& camera,
                                       const CameraOptions& options,
                                       V4l2System& system);

}  // namespace livemvs
