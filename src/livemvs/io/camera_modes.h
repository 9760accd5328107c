#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace livemvs {

class V4l2System;

/// What a camera can send.
struct CameraMode {
  std::string format;  ///< "yuyv", "nv12", "grey", "mjpeg" or "h264".
  int width = 0;       ///< [px]
  int height = 0;      ///< [px]
  double rate = 0;     ///< [Hz]; 0: unknown.
};

/// "1280x720@30:mjpeg", as ParseMode() reads it.
std::string ToString(const CameraMode& mode);

/// What is wished of a camera; what is left out is chosen.
struct ModeWish {
  std::string format;
  int width = 0;
  int height = 0;
  double rate = 0;
};

/// Reads "1280x720", "1280x720@60", "640x480:yuyv", "@30", ":mjpeg" and so on.
/// @throws std::invalid_argument naming what is wrong.
ModeWish ParseMode(const std::string& text);

struct CameraDevice {
  std::string path;
  std::string name;  ///< As the driver says it.
  std::string bus;   ///< Where it is plugged in.
  std::vector<CameraMode> modes;
};

/// The cameras there are, by their numbers, with those of their modes that can be read. Devices
/// that are no cameras, or cannot be asked, are left out.
std::vector<CameraDevice> ListCameras();
std::vector<CameraDevice> ListCameras(V4l2System& system);

/// Of one device; nothing where it is no camera.
std::optional<CameraDevice> QueryCamera(V4l2System& system, int fd, const std::string& path);

/// The mode that fits a wish best. Of those that fit: 25 Hz and more before less, then about
/// 1.2 megapixels, then the highest rate, then raw pictures before compressed ones.
std::optional<CameraMode> ChooseMode(const std::vector<CameraMode>& modes, const ModeWish& wish);

/// V4L2's number of a format; 0: none.
std::uint32_t FourccOf(const std::string& format);
/// Our name of one of V4L2's formats; empty: it is not read.
std::string FormatOf(std::uint32_t fourcc);

}  // namespace livemvs
