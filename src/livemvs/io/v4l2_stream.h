#pragma once

/// A camera that is sending. Private to io/.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "livemvs/core/frame.h"
#include "livemvs/io/camera_modes.h"
#include "livemvs/io/live_decoder.h"
#include "livemvs/io/v4l2_system.h"

namespace livemvs {

/// Streaming from one opened device; the destructor stops and closes it. Not thread-safe.
class V4l2Stream {
 public:
  /// @throws Error (kBadInput) naming the device and the remedy, where it cannot be opened, is no
  /// camera, has no such mode, or is in use.
  V4l2Stream(V4l2System& system, const std::string& path, const ModeWish& wish);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  const CameraDevice& device() const { return device_; }
  /// As the driver made it of the wish.
  const CameraMode& mode() const { return mode_; }

  enum class Status { kPicture, kNothing, kGone };
  struct Answer {
    Status status = Status::kNothing;
    Picture picture;
    /// Of capture, by the monotonic clock [s]; nothing where the driver uses another one.
    std::optional<double> time;
  };
  /// Waits up to about `timeout_ms`.
  Answer Next(int timeout_ms);

  /// Whether the device still answers.
  bool Alive();

  /// Keeps exposure, focus and white balance as they are now, as far as the driver can.
  void LockControls();

  std::int64_t damaged() const { return damaged_ + (decoder_ ? decoder_->damaged() : 0); }

 private:
  struct Buffer {
    void* memory;
    std::size_t length;
  };
  void Start(const ModeWish& wish);
  void SetMode(const ModeWish& wish);
  void MapBuffers();
  void Release();
  bool Call(unsigned long request, void* argument);
  std::optional<Picture> Decode(const std::uint8_t* data, std::size_t size);
  std::optional<Picture> ConvertRaw(const std::uint8_t* data, std::size_t size);
  bool SetControl(std::uint32_t id, std::int32_t value);

  V4l2System& system_;
  std::string path_;
  int fd_ = -1;
  CameraDevice device_;
  CameraMode mode_;
  std::size_t bytes_per_line_ = 0;
  std::vector<Buffer> buffers_;
  bool streaming_ = false;
  std::optional<LiveDecoder> decoder_;
  ffmpeg::FrameConverter converter_;
  std::int64_t damaged_ = 0;
};

}  // namespace livemvs
