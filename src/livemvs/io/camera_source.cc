#include "livemvs/io/camera_source.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/io/v4l2_stream.h"

namespace livemvs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSliceMs = 100;
constexpr double kSilence = 2;    // [s] after which the camera is started anew
constexpr double kLockAfter = 1;  // [s] for the automatic to settle

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

class CameraSource final : public LiveSource {
 public:
  CameraSource(const std::string& path, const CameraOptions& options, V4l2System& system)
      : system_(system),
        options_(options),
        path_(path),
        stream_(std::make_unique<V4l2Stream>(system, path, options.mode)),
        device_(stream_->device()),
        mode_(stream_->mode()) {
    info_.width = mode_.width;
    info_.height = mode_.height;
    info_.frames_per_second = mode_.rate;
    info_.description = path + ": " + device_.name + ", " + ToString(mode_);
  }

  FrameSource::Info info() const override { return info_; }
  FrameSource::Statistics statistics() const override { return statistics_; }
  void Cancel() override { cancelled_ = true; }

  Answer Next() override {
    Answer answer;
    if (cancelled_) return answer;
    if (stream_ == nullptr) {
      Reconnect();
      return answer;
    }
    V4l2Stream::Answer next = stream_->Next(kSliceMs);
    statistics_.skipped = skipped_before_ + stream_->damaged();
    const Clock::time_point now = Clock::now();
    if (next.status == V4l2Stream::Status::kPicture) {
      answer.status = Status::kFrame;
      answer.frame = MakeFrame(std::move(next), now);
      Lock(now);
      return answer;
    }
    const bool silent = Seconds(now - last_picture_) > kSilence;
    if (next.status == V4l2Stream::Status::kGone || silent || !stream_->Alive()) {
      Disconnect();
      answer.status = Status::kLost;
      answer.problem = path_ + (silent ? ": sends nothing" : ": unplugged");
    }
    return answer;
  }

 private:
  void Disconnect() {
    skipped_before_ = statistics_.skipped;
    stream_.reset();
  }

  // In the mode it had, for the calibration's sake; maybe at another place.
  void Reconnect() {
    std::this_thread::sleep_for(std::chrono::milliseconds(kSliceMs));
    const ModeWish same{mode_.format, mode_.width, mode_.height, mode_.rate};
    std::string path = path_;
    for (const CameraDevice& device : ListCameras(system_)) {
      if (device.name != device_.name) continue;
      path = device.path;
      if (device.bus == device_.bus) break;
    }
    try {
      stream_ = std::make_unique<V4l2Stream>(system_, path, same);
      path_ = path;
      last_picture_ = started_ = Clock::now();
      locked_ = false;
    } catch (const Error&) {  // not yet
    }
  }

  void Lock(Clock::time_point now) {
    if (!options_.lock_controls || locked_ || Seconds(now - started_) < kLockAfter) return;
    stream_->LockControls();
    locked_ = true;
  }

  SourceFrame MakeFrame(V4l2Stream::Answer next, Clock::time_point now) {
    last_picture_ = now;
    // The steady clock is the monotonic one, so that both kinds of times can follow each other.
    const double time = next.time ? *next.time : Seconds(now.time_since_epoch());
    if (!begin_) begin_ = time;
    SourceFrame frame;
    frame.index = next_index_++;
    frame.timestamp = time - *begin_;
    frame.name = "frame " + std::to_string(frame.index);
    frame.picture = std::make_shared<const Picture>(std::move(next.picture));
    ++statistics_.decoded;
    return frame;
  }

  V4l2System& system_;
  CameraOptions options_;
  std::string path_;
  std::unique_ptr<V4l2Stream> stream_;
  CameraDevice device_;
  CameraMode mode_;
  FrameSource::Info info_;
  FrameSource::Statistics statistics_;
  std::int64_t skipped_before_ = 0;
  std::int64_t next_index_ = 0;
  std::optional<double> begin_;
  Clock::time_point last_picture_ = Clock::now();
  Clock::time_point started_ = last_picture_;
  bool locked_ = false;
  std::atomic<bool> cancelled_ = false;
};

}  // namespace

std::string CameraPath(const std::string& camera) {
  const bool number = !camera.empty() && std::all_of(camera.begin(), camera.end(), [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
  return number ? "/dev/video" + camera : camera;
}

std::unique_ptr<LiveSource> OpenCamera(const std::string& camera,
                                       const CameraOptions& options,
                                       V4l2System& system) {
  return std::make_unique<CameraSource>(CameraPath(camera), options, system);
}

std::unique_ptr<LiveSource> OpenCamera(const std::string& camera, const CameraOptions& options) {
  return OpenCamera(camera, options, RealV4l2System());
}

}  // namespace livemvs
