#pragma once

/// A camera at the level of system calls, for faults that a real one does not produce on demand.

#include <linux/videodev2.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "livemvs/io/v4l2_system.h"

namespace livemvs {

/// Sends `pictures` in turn, as bytes of the chosen format. May be used from several threads.
class FakeV4l2 final : public V4l2System {
 public:
  std::map<std::uint32_t, std::vector<std::string>> pictures;  ///< By format.
  std::string path = "/dev/video2";
  std::uint32_t width = 160, height = 96;
  std::uint32_t line_padding = 0;  ///< [bytes]
  bool plugged_in = true;
  bool silent = false;
  bool busy = false;
  bool refuses_formats = false;  ///< Answers S_FMT with another size.
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::map<int, std::uint32_t> flags_of;       ///< Of the n-th picture, in place of its own.
  std::map<int, std::uint32_t> bytes_used_of;  ///< Of the n-th picture.
  std::map<std::uint32_t, std::int32_t> controls;
  int opened = 0;  ///< Files that are open.
  int mapped = 0;
  int sent = 0;
  double rate_set = 0;

  std::vector<std::string> Devices() override {
    const std::lock_guard<std::recursive_mutex> lock(mutex);
    return plugged_in ? std::vector<std::string>{path} : std::vector<std::string>{};
  }
  int Open(const std::string& wanted) override {
    const std::lock_guard<std::recursive_mutex> lock(mutex);
    if (!plugged_in || wanted != path) return Fail(ENOENT);
    ++opened;
    return 1000 + opened;
  }
  void Close(int /*fd*/) override {
    const std::lock_guard<std::recursive_mutex> lock(mutex);
    --opened;
  }
  void* Map(int /*fd*/, std::size_t length, std::size_t offset) override {
    const std::lock_guard<std::recursive_mutex> lock(mutex);
    ++mapped;
    memory_[offset].resize(length);
    return memory_[offset].data();
  }
  void Unmap(void* /*memory*/, std::size_t /*length*/) override {
    const std::lock_guard<std::recursive_mutex> lock(mutex);
    --mapped;
  }
  Ready Wait(int /*fd*/, int timeout_ms) override {
    {
      const std::lock_guard<std::recursive_mutex> lock(mutex);
      if (!plugged_in) return Ready::kBroken;
      if (!silent && !queued_.empty()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        return Ready::kYes;
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
    return Ready::kNo;
  }
  int Ioctl(int /*fd*/, unsigned long request, void* argument) override {
    const std::lock_guard<std::recursive_mutex> lock(mutex);
    if (!plugged_in) return Fail(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP:
        return QueryCapability(static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT:
        return EnumerateFormat(static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_ENUM_FRAMESIZES:
        return EnumerateSize(static_cast<v4l2_frmsizeenum*>(argument));
      case VIDIOC_ENUM_FRAMEINTERVALS:
        return EnumerateInterval(static_cast<v4l2_frmivalenum*>(argument));
      case VIDIOC_S_FMT:
        return SetFormat(static_cast<v4l2_format*>(argument));
      case VIDIOC_S_PARM:
        return SetRate(static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_REQBUFS:
        queued_.clear();
        return 0;
      case VIDIOC_QUERYBUF:
        return QueryBuffer(static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF:
        queued_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF:
        return Dequeue(static_cast<v4l2_buffer*>(argument));
      case VIDIOC_S_CTRL: {
        const auto* control = static_cast<v4l2_control*>(argument);
        controls[control->id] = control->value;
        return 0;
      }
      case VIDIOC_G_CTRL: {
        auto* control = static_cast<v4l2_control*>(argument);
        control->value = 123;
        return 0;
      }
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        return 0;
      default:
        return Fail(ENOTTY);
    }
  }

  std::recursive_mutex mutex;

 private:
  static int Fail(int error) {
    errno = error;
    return -1;
  }
  static void Put(const char* text, void* out) { std::memcpy(out, text, std::strlen(text) + 1); }

  int QueryCapability(v4l2_capability* out) const {
    Put("Fake camera", out->card);
    Put("usb-1.2", out->bus_info);
    out->capabilities = capabilities | V4L2_CAP_DEVICE_CAPS;
    out->device_caps = capabilities;
    return 0;
  }
  int EnumerateFormat(v4l2_fmtdesc* out) const {
    if (out->index > pictures.size()) return Fail(EINVAL);
    if (out->index == pictures.size()) {
      out->pixelformat = v4l2_fourcc('P', 'W', 'C', '1');  // one that nobody reads
      return 0;
    }
    auto it = pictures.begin();
    std::advance(it, out->index);
    out->pixelformat = it->first;
    return 0;
  }
  int EnumerateSize(v4l2_frmsizeenum* out) const {
    if (out->index > 1) return Fail(EINVAL);
    out->type = V4L2_FRMSIZE_TYPE_DISCRETE;
    out->discrete.width = width * (out->index + 1);
    out->discrete.height = height * (out->index + 1);
    return 0;
  }
  int EnumerateInterval(v4l2_frmivalenum* out) const {
    if (out->index > 1) return Fail(EINVAL);
    out->type = V4L2_FRMIVAL_TYPE_DISCRETE;
    out->discrete = {1, out->index == 0 ? 30U : 15U};
    return 0;
  }
  int SetFormat(v4l2_format* format) {
    if (busy) return Fail(EBUSY);
    v4l2_pix_format& pix = format->fmt.pix;
    if (refuses_formats) pix.width = 80;
    format_ = pix.pixelformat;
    if (format_ == V4L2_PIX_FMT_YUYV) pix.bytesperline = 2 * pix.width + line_padding;
    pix.sizeimage = 4 * pix.width * pix.height;
    size_ = pix.sizeimage;
    return 0;
  }
  int SetRate(const v4l2_streamparm* in) {
    rate_set = static_cast<double>(in->parm.capture.timeperframe.denominator) /
               in->parm.capture.timeperframe.numerator;
    return 0;
  }
  int QueryBuffer(v4l2_buffer* buffer) const {
    buffer->length = size_;
    buffer->m.offset = 65536 * 16 * buffer->index;
    return 0;
  }
  int Dequeue(v4l2_buffer* buffer) {
    if (queued_.empty() || silent) return Fail(EAGAIN);
    buffer->index = queued_.front();
    queued_.erase(queued_.begin());
    const std::vector<std::string>& all = pictures[format_];
    const std::string& bytes = all[static_cast<std::size_t>(sent) % all.size()];
    std::vector<char>& memory = memory_[65536 * 16 * buffer->index];
    std::memcpy(memory.data(), bytes.data(), std::min(bytes.size(), memory.size()));
    buffer->bytesused = static_cast<std::uint32_t>(bytes.size());
    buffer->flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    buffer->timestamp.tv_sec = 100 + sent / 30;
    buffer->timestamp.tv_usec = (sent % 30) * 33333;
    if (flags_of.count(sent) > 0) buffer->flags = flags_of[sent];
    if (bytes_used_of.count(sent) > 0) buffer->bytesused = bytes_used_of[sent];
    ++sent;
    return 0;
  }

  std::map<std::size_t, std::vector<char>> memory_;
  std::vector<std::uint32_t> queued_;
  std::uint32_t format_ = 0;
  std::uint32_t size_ = 0;
};

}  // namespace livemvs
