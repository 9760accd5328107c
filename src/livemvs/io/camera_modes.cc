#include "livemvs/io/camera_modes.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <tuple>

#include "livemvs/io/v4l2_system.h"

namespace livemvs {
namespace {

struct PixelFormat {
  const char* name;
  std::uint32_t fourcc;
  int cost;  ///< What the picture loses: raw ones before compressed ones.
};

constexpr std::array<PixelFormat, 6> kFormats = {{{"yuyv", V4L2_PIX_FMT_YUYV, 0},
                                                  {"nv12", V4L2_PIX_FMT_NV12, 0},
                                                  {"grey", V4L2_PIX_FMT_GREY, 1},
                                                  {"mjpeg", V4L2_PIX_FMT_MJPEG, 2},
                                                  {"mjpeg", V4L2_PIX_FMT_JPEG, 2},
                                                  {"h264", V4L2_PIX_FMT_H264, 3}}};

/// A driver that never ends its lists is not followed for ever.
constexpr std::uint32_t kMostEntries = 256;

const std::array<std::array<int, 2>, 5> kUsualSizes = {
    {{640, 480}, {1280, 720}, {1280, 960}, {1920, 1080}, {3840, 2160}}};

std::string TextOf(const unsigned char* bytes, std::size_t size) {
  const auto* text = reinterpret_cast<const char*>(bytes);
  return {text, strnlen(text, size)};
}

double RateOf(const v4l2_fract& interval) {
  return interval.numerator > 0 ? static_cast<double>(interval.denominator) / interval.numerator
                                : 0;
}

std::vector<double> Rates(V4l2System& system, int fd, std::uint32_t fourcc, int width, int height) {
  std::vector<double> rates;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_frmivalenum entry{};
    entry.index = i;
    entry.pixel_format = fourcc;
    entry.width = static_cast<std::uint32_t>(width);
    entry.height = static_cast<std::uint32_t>(height);
    if (system.Ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &entry) < 0) break;
    if (entry.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      rates.push_back(RateOf(entry.discrete));
      continue;
    }
    rates.push_back(RateOf(entry.stepwise.min));  // the shortest interval: the highest rate
    break;
  }
  if (rates.empty()) rates.push_back(0);
  return rates;
}

std::vector<std::array<int, 2>> Sizes(V4l2System& system, int fd, std::uint32_t fourcc) {
  std::vector<std::array<int, 2>> sizes;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_frmsizeenum entry{};
    entry.index = i;
    entry.pixel_format = fourcc;
    if (system.Ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &entry) < 0) break;
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      sizes.push_back(
          {static_cast<int>(entry.discrete.width), static_cast<int>(entry.discrete.height)});
      continue;
    }
    const v4l2_frmsize_stepwise& s = entry.stepwise;
    for (const auto& [width, height] : kUsualSizes) {
      const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
      if (w >= s.min_width && w <= s.max_width && h >= s.min_height && h <= s.max_height) {
        sizes.push_back({width, height});
      }
    }
    break;
  }
  return sizes;
}

int CostOf(const std::string& format) {
  for (const PixelFormat& f : kFormats) {
    if (format == f.name) return f.cost;
  }
  return 9;
}

std::invalid_argument BadMode(const std::string& text) {
  return std::invalid_argument("--mode " + text +
                               ": must be WIDTHxHEIGHT@RATE:FORMAT, as 1280x720@30:mjpeg; what is "
                               "left out is chosen");
}

// Takes a number off the front.
double NumberAt(const std::string& text, std::size_t* at) {
  double value = 0;
  const char* begin = text.data() + *at;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || !(value > 0 && value < 100'000)) throw BadMode(text);
  *at += static_cast<std::size_t>(end - begin);
  return value;
}

}  // namespace

std::string ToString(const CameraMode& mode) {
  char text[64];
  std::snprintf(text, sizeof(text), "%dx%d@%.4g:", mode.width, mode.height, mode.rate);
  return text + mode.format;
}

ModeWish ParseMode(const std::string& text) {
  ModeWish wish;
  std::size_t at = 0;
  if (at < text.size() && text[at] != '@' && text[at] != ':') {
    wish.width = static_cast<int>(NumberAt(text, &at));
    if (at < text.size() && text[at] == 'x') ++at;
    wish.height = static_cast<int>(NumberAt(text, &at));
  }
  if (at < text.size() && text[at] == '@') wish.rate = NumberAt(text, &++at);
  if (at < text.size() && text[at] == ':') {
    wish.format = text.substr(at + 1);
    at = text.size();
  }
  if (at != text.size()) throw BadMode(text);
  if (!wish.format.empty() && FourccOf(wish.format) == 0) {
    throw std::invalid_argument("--mode " + text +
                                ": the format must be yuyv, nv12, grey, mjpeg or h264");
  }
  return wish;
}

std::uint32_t FourccOf(const std::string& format) {
  for (const PixelFormat& f : kFormats) {
    if (format == f.name) return f.fourcc;
  }
  return 0;
}

std::string FormatOf(std::uint32_t fourcc) {
  for (const PixelFormat& f : kFormats) {
    if (fourcc == f.fourcc) return f.name;
  }
  return "";
}

std::optional<CameraDevice> QueryCamera(V4l2System& system, int fd, const std::string& path) {
  v4l2_capability capability{};
  if (system.Ioctl(fd, VIDIOC_QUERYCAP, &capability) < 0) return std::nullopt;
  const std::uint32_t all = capability.capabilities;
  const std::uint32_t can = (all & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : all;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) return std::nullopt;
  CameraDevice device;
  device.path = path;
  device.name = TextOf(capability.card, sizeof(capability.card));
  device.bus = TextOf(capability.bus_info, sizeof(capability.bus_info));
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (system.Ioctl(fd, VIDIOC_ENUM_FMT, &description) < 0) break;
    const std::string format = FormatOf(description.pixelformat);
    if (format.empty()) continue;
    for (const auto& [width, height] : Sizes(system, fd, description.pixelformat)) {
      for (const double rate : Rates(system, fd, description.pixelformat, width, height)) {
        device.modes.push_back({format, width, height, rate});
      }
    }
  }
  return device;
}

std::vector<CameraDevice> ListCameras(V4l2System& system) {
  std::vector<CameraDevice> cameras;
  for (const std::string& path : system.Devices()) {
    const int fd = system.Open(path);
    if (fd < 0) continue;
    if (std::optional<CameraDevice> camera = QueryCamera(system, fd, path)) {
      cameras.push_back(*std::move(camera));
    }
    system.Close(fd);
  }
  return cameras;
}

std::vector<CameraDevice> ListCameras() { return ListCameras(RealV4l2System()); }

std::optional<CameraMode> ChooseMode(const std::vector<CameraMode>& modes, const ModeWish& wish) {
  constexpr double kGoodRate = 24.5;
  constexpr double kGoodPixels = 1280 * 960;
  constexpr double kRateTolerance = 0.6;  // 29.97 is meant by 30
  std::optional<CameraMode> best;
  const auto rank = [](const CameraMode& m) {
    const double pixels = static_cast<double>(m.width) * m.height;
    return std::make_tuple(m.rate < kGoodRate && m.rate > 0,
                           std::abs(std::log(pixels / kGoodPixels)),
                           -m.rate,
                           CostOf(m.format));
  };
  for (const CameraMode& mode : modes) {
    if (!wish.format.empty() && mode.format != wish.format) continue;
    if (wish.width > 0 && (mode.width != wish.width || mode.height != wish.height)) continue;
    if (wish.rate > 0 && mode.rate > 0 && std::abs(mode.rate - wish.rate) > kRateTolerance) {
      continue;
    }
    if (!best || rank(mode) < rank(*best)) best = mode;
  }
  return best;
}

}  // namespace livemvs
