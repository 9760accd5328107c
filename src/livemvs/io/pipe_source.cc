#include "livemvs/io/pipe_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "livemvs/core/error.h"
#include "livemvs/core/log.h"
#include "livemvs/io/pipe_reader.h"
#include "livemvs/io/pipe_stream.h"

namespace livemvs {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class PipeSource final : public LiveSource {
 public:
  PipeSource(const std::filesystem::path& path, const PipeOptions& options)
      : name_(path == "-" ? "standard input" : path.string()), options_(options), reader_(path) {
    // Until the first picture, patience is limited.
    const Clock::time_point start = Clock::now();
    const auto impatient = [this, start] {
      return SecondsSince(start) > options_.open_timeout ||
             (options_.cancelled && options_.cancelled());
    };
    while (reader_.is_fifo() && !impatient() && !reader_.WaitForWriter()) continue;
    reader_.give_up = impatient;
    try {
      Connect();
      first_ = stream_->Next();
    } catch (const Error& e) {
      if (!impatient()) throw;
    }
    if (!first_) {
      throw BadInput(name_ + ": no picture came within " +
                     std::to_string(std::llround(options_.open_timeout)) +
                     " s; start the program that writes to it");
    }
    reader_.give_up = nullptr;
    Describe();
  }

  FrameSource::Info info() const override { return info_; }
  FrameSource::Statistics statistics() const override { return statistics_; }
  void Cancel() override { reader_.Cancel(); }

  Answer Next() override {
    Answer answer;
    if (reader_.cancelled()) return answer;
    if (stream_ == nullptr && !Reconnect()) return answer;
    std::optional<PipeStream::Output> output =
        first_ ? std::exchange(first_, std::nullopt) : stream_->Next();
    statistics_.skipped = skipped_before_ + stream_->damaged();
    if (!output) return Disconnect();
    answer.frame = MakeFrame(*std::move(output));
    answer.status = Status::kFrame;
    return answer;
  }

 private:
  void Connect() {
    stream_ = std::make_unique<PipeStream>(name_, options_, &reader_);
    stream_start_.reset();
  }

  bool Reconnect() {
    if (!reader_.WaitForWriter()) return false;
    try {
      Connect();
    } catch (const Error& e) {
      LogWarning(e.what());
      return false;
    }
    const AVCodecParameters& now = *stream_->stream().codecpar;
    if (now.width == info_.width && now.height == info_.height) return true;
    throw BadInput(name_ + ": the pictures are now " + std::to_string(now.width) + " x " +
                   std::to_string(now.height) + ", and were " + std::to_string(info_.width) +
                   " x " + std::to_string(info_.height));
  }

  Answer Disconnect() {
    Answer answer;
    skipped_before_ = statistics_.skipped;
    stream_.reset();
    if (reader_.cancelled()) return answer;
    answer.status = reader_.is_fifo() ? Status::kLost : Status::kEnded;
    answer.problem = name_ + ": its writer has gone";
    return answer;
  }

  SourceFrame MakeFrame(PipeStream::Output output) {
    if (!begin_) begin_ = Clock::now();
    const double now = SecondsSince(*begin_);
    // What has no time of its own has that of its coming, yet after the latest picture, whose
    // stream may have been sent faster than its times say. So it is with where a stream begins.
    const double next = std::max(now, latest_ + 1e-3);
    double timestamp = next;
    if (output.time) {
      if (!stream_start_) stream_start_ = std::max(now, latest_ + FrameSeconds()) - *output.time;
      timestamp = *output.time + *stream_start_;
    }
    SourceFrame frame;
    frame.index = next_index_++;
    frame.timestamp = timestamp;
    latest_ = std::max(latest_, timestamp);
    frame.name = "frame " + std::to_string(frame.index);
    frame.picture = std::make_shared<const Picture>(std::move(output.picture));
    ++statistics_.decoded;
    return frame;
  }

  double FrameSeconds() const {
    return info_.frames_per_second > 0 ? 1 / info_.frames_per_second : 1e-3;
  }

  void Describe() {
    const AVStream& stream = stream_->stream();
    info_.width = stream.codecpar->width;
    info_.height = stream.codecpar->height;
    if (stream_->has_times() && stream.avg_frame_rate.num > 0 && stream.avg_frame_rate.den > 0) {
      info_.frames_per_second = av_q2d(stream.avg_frame_rate);
    }
    info_.description = "pipe of " + std::string(avcodec_get_name(stream.codecpar->codec_id)) +
                        " pictures, " + std::to_string(info_.width) + " x " +
                        std::to_string(info_.height);
  }

  std::string name_;
  PipeOptions options_;
  PipeReader reader_;
  std::unique_ptr<PipeStream> stream_;
  std::optional<PipeStream::Output> first_;
  FrameSource::Info info_;
  FrameSource::Statistics statistics_;
  std::int64_t skipped_before_ = 0;
  std::int64_t next_index_ = 0;
  std::optional<Clock::time_point> begin_;
  std::optional<double> stream_start_;  ///< What to add to the stream's times.
  double latest_ = -std::numeric_limits<double>::infinity();  ///< Time of a picture so far.
};

void CheckRaw(const PipeOptions& options) {
  if (!IsRaw(options)) return;
  static constexpr const char* kFormats[] = {"yuyv422", "nv12", "yuv420p", "gray"};
  const bool known = std::any_of(
      std::begin(kFormats), std::end(kFormats), [&](const char* f) { return options.format == f; });
  if (!known) {
    throw std::invalid_argument("--pipe-format " + options.format +
                                ": must be yuyv422, nv12, yuv420p or gray, with the size");
  }
  CheckPictureSize("--pipe-format", options.width, options.height);
}

}  // namespace

bool IsPipe(const std::filesystem::path& path) {
  std::error_code error;
  return path == "-" || std::filesystem::is_fifo(path, error);
}

std::unique_ptr<LiveSource> OpenPipe(const std::filesystem::path& path,
                                     const PipeOptions& options) {
  CheckRaw(options);
  return std::make_unique<PipeSource>(path, options);
}

}  // namespace livemvs
