#include "livemvs/io/v4l2_stream.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

constexpr std::uint32_t kBuffers = 4;

AVPixelFormat PixelFormatOf(const std::string& format) {
  if (format == "yuyv") return AV_PIX_FMT_YUYV422;
  if (format == "nv12") return AV_PIX_FMT_NV12;
  if (format == "grey") return AV_PIX_FMT_GRAY8;
  return AV_PIX_FMT_NONE;
}

AVCodecID CodecOf(const std::string& format) {
  return format == "h264" ? AV_CODEC_ID_H264 : AV_CODEC_ID_MJPEG;
}

std::string Reason(int error) {
  switch (error) {
    case EBUSY:
      return "is in use by another program; close that";
    case EACCES:
    case EPERM:
      return "may not be opened; add yourself to the group 'video' and log in again";
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "is not there; see 'livemvs cameras'";
    default:
      return std::generic_category().message(error);
  }
}

std::string Modes(const CameraDevice& device) {
  std::string text;
  for (std::size_t i = 0; i < device.modes.size() && i < 12; ++i) {
    text += (i > 0 ? ", " : "") + ToString(device.modes[i]);
  }
  return text.empty() ? "none that can be read" : text;
}

}  // namespace

V4l2Stream::V4l2Stream(V4l2System& system, const std::string& path, const ModeWish& wish)
    : system_(system), path_(path), fd_(system.Open(path)) {
  if (fd_ < 0) throw BadInput(path + ": the camera " + Reason(errno));
  try {
    Start(wish);
  } catch (...) {
    Release();
    throw;
  }
}

V4l2Stream::~V4l2Stream() { Release(); }

void V4l2Stream::Release() {
  if (streaming_) {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    Call(VIDIOC_STREAMOFF, &type);
  }
  for (const Buffer& buffer : buffers_) system_.Unmap(buffer.memory, buffer.length);
  if (fd_ >= 0) system_.Close(fd_);
  fd_ = -1;
}

bool V4l2Stream::Call(unsigned long request, void* argument) {
  return system_.Ioctl(fd_, request, argument) >= 0;
}

void V4l2Stream::Start(const ModeWish& wish) {
  std::optional<CameraDevice> device = QueryCamera(system_, fd_, path_);
  if (!device) throw BadInput(path_ + ": is no camera that streams; see 'livemvs cameras'");
  device_ = *std::move(device);
  SetMode(wish);
  MapBuffers();
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (!Call(VIDIOC_STREAMON, &type)) throw BadInput(path_ + ": the camera " + Reason(errno));
  streaming_ = true;
}

void V4l2Stream::SetMode(const ModeWish& wish) {
  const std::optional<CameraMode> mode = ChooseMode(device_.modes, wish);
  if (!mode) throw BadInput(path_ + ": has no such mode; it has " + Modes(device_));
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<std::uint32_t>(mode->width);
  format.fmt.pix.height = static_cast<std::uint32_t>(mode->height);
  format.fmt.pix.pixelformat = FourccOf(mode->format);
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (!Call(VIDIOC_S_FMT, &format)) throw BadInput(path_ + ": the camera " + Reason(errno));
  // Drivers may answer with something else.
  mode_ = *mode;
  mode_.width = static_cast<int>(format.fmt.pix.width);
  mode_.height = static_cast<int>(format.fmt.pix.height);
  mode_.format = FormatOf(format.fmt.pix.pixelformat);
  bytes_per_line_ = format.fmt.pix.bytesperline;
  if (mode_.format.empty()) throw BadInput(path_ + ": sends pictures in a form that is not read");
  CheckPictureSize(path_, mode_.width, mode_.height);
  const bool other_size =
      wish.width > 0 && (wish.width != mode_.width || wish.height != mode_.height);
  if (other_size) {
    throw BadInput(path_ + ": the camera made " + ToString(mode_) +
                   " of the mode that was asked for");
  }
  if (mode->rate > 0) {
    v4l2_streamparm parameters{};
    parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    parameters.parm.capture.timeperframe.numerator = 1000;
    parameters.parm.capture.timeperframe.denominator =
        static_cast<std::uint32_t>(std::lround(1000 * mode->rate));
    Call(VIDIOC_S_PARM, &parameters);  // where it cannot, it keeps its own rate
  }
  if (PixelFormatOf(mode_.format) != AV_PIX_FMT_NONE) return;
  AVCodecParameters* parameters = avcodec_parameters_alloc();
  if (parameters == nullptr) throw std::bad_alloc();
  parameters->codec_type = AVMEDIA_TYPE_VIDEO;
  parameters->codec_id = CodecOf(mode_.format);
  parameters->width = mode_.width;
  parameters->height = mode_.height;
  const std::unique_ptr<AVCodecParameters, void (*)(AVCodecParameters*)> owner(
      parameters, [](AVCodecParameters* p) { avcodec_parameters_free(&p); });
  decoder_.emplace(path_, *parameters);
}

void V4l2Stream::MapBuffers() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (!Call(VIDIOC_REQBUFS, &request)) throw BadInput(path_ + ": the camera " + Reason(errno));
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer{};
    buffer.index = i;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (!Call(VIDIOC_QUERYBUF, &buffer)) throw BadInput(path_ + ": the camera " + Reason(errno));
    void* memory = system_.Map(fd_, buffer.length, buffer.m.offset);
    if (memory == nullptr) {
      throw Error(ErrorKind::kOutOfResource, path_ + ": no memory for its pictures");
    }
    buffers_.push_back({memory, buffer.length});
    if (!Call(VIDIOC_QBUF, &buffer)) throw BadInput(path_ + ": the camera " + Reason(errno));
  }
  if (buffers_.empty()) throw BadInput(path_ + ": the camera gives no room for pictures");
}

bool V4l2Stream::Alive() {
  v4l2_capability capability{};
  return Call(VIDIOC_QUERYCAP, &capability);
}

V4l2Stream::Answer V4l2Stream::Next(int timeout_ms) {
  Answer answer;
  const V4l2System::Ready ready = system_.Wait(fd_, timeout_ms);
  if (ready == V4l2System::Ready::kNo) return answer;
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  if (ready == V4l2System::Ready::kBroken || !Call(VIDIOC_DQBUF, &buffer)) {
    const bool later = ready == V4l2System::Ready::kYes && errno == EAGAIN;
    answer.status = later ? Status::kNothing : Status::kGone;
    return answer;
  }
  const bool sane =
      buffer.index < buffers_.size() && buffer.bytesused <= buffers_[buffer.index].length;
  std::optional<Picture> picture;
  if (sane && (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0) {
    picture =
        Decode(static_cast<const std::uint8_t*>(buffers_[buffer.index].memory), buffer.bytesused);
  } else {
    ++damaged_;
  }
  const std::uint32_t clock = buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK;
  if (clock == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    answer.time = static_cast<double>(buffer.timestamp.tv_sec) +
                  1e-6 * static_cast<double>(buffer.timestamp.tv_usec);
  }
  if (sane && !Call(VIDIOC_QBUF, &buffer)) answer.status = Status::kGone;
  if (picture && answer.status != Status::kGone) {
    answer.status = Status::kPicture;
    answer.picture = *std::move(picture);
  }
  return answer;
}

std::optional<Picture> V4l2Stream::Decode(const std::uint8_t* data, std::size_t size) {
  if (!decoder_) return ConvertRaw(data, size);
  ffmpeg::Packet packet = ffmpeg::MakePacket();
  // Decoders read a little beyond the end: the bytes are copied into room for that.
  if (av_new_packet(packet.get(), static_cast<int>(size)) < 0) throw std::bad_alloc();
  std::memcpy(packet->data, data, size);
  decoder_->Send(*packet);
  std::optional<Picture> newest;
  while (std::optional<LiveDecoder::Output> output = decoder_->Receive()) {
    newest = std::move(output->picture);
  }
  return newest;
}

std::optional<Picture> V4l2Stream::ConvertRaw(const std::uint8_t* data, std::size_t size) {
  const AVPixelFormat format = PixelFormatOf(mode_.format);
  const auto width = static_cast<std::size_t>(mode_.width);
  const auto height = static_cast<std::size_t>(mode_.height);
  const std::size_t least_line = format == AV_PIX_FMT_YUYV422 ? 2 * width : width;
  const std::size_t line = std::max(bytes_per_line_, least_line);
  const std::size_t lines = format == AV_PIX_FMT_NV12 ? height + (height + 1) / 2 : height;
  if (size < line * (lines - 1) + least_line) {  // cut short on its way
    ++damaged_;
    return std::nullopt;
  }
  ffmpeg::Frame frame = ffmpeg::MakeFrame();
  frame->width = mode_.width;
  frame->height = mode_.height;
  frame->format = format;
  // It is only read; the owner is the driver's buffer.
  frame->data[0] = const_cast<std::uint8_t*>(data);
  frame->linesize[0] = static_cast<int>(line);
  if (format == AV_PIX_FMT_NV12) {
    frame->data[1] = frame->data[0] + line * height;
    frame->linesize[1] = static_cast<int>(line);
  }
  return converter_.Convert(*frame);
}

bool V4l2Stream::SetControl(std::uint32_t id, std::int32_t value) {
  v4l2_control control{};
  control.id = id;
  control.value = value;
  return Call(VIDIOC_S_CTRL, &control);
}

void V4l2Stream::LockControls() {
  // Some drivers go back to an older value when the automatic ends: set the present one.
  const std::array<std::array<std::uint32_t, 3>, 3> controls = {
      {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, V4L2_CID_EXPOSURE_ABSOLUTE},
       {V4L2_CID_FOCUS_AUTO, 0, V4L2_CID_FOCUS_ABSOLUTE},
       {V4L2_CID_AUTO_WHITE_BALANCE, 0, V4L2_CID_WHITE_BALANCE_TEMPERATURE}}};
  for (const auto& [automatic, off, value_id] : controls) {
    v4l2_control present{};
    present.id = value_id;
    const bool known = Call(VIDIOC_G_CTRL, &present);
    if (SetControl(automatic, static_cast<std::int32_t>(off)) && known) {
      SetControl(value_id, present.value);
    }
  }
}

}  // namespace livemvs
