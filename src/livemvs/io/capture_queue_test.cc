#include "livemvs/io/capture_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace livemvs {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kPatience{2000};

// Frames 0, 1, 2 ... at a pace; may be silent or fail.
class ScriptedSource final : public LiveSource {
 public:
  ScriptedSource(std::int64_t count, milliseconds pace) : count_(count), pace_(pace) {}

  FrameSource::Info info() const override { return {}; }
  FrameSource::Statistics statistics() const override { return {next_, 0}; }
  void Cancel() override { cancelled_ = true; }
  Answer Next() override {
    if (pace_ > milliseconds(0)) std::this_thread::sleep_for(pace_);
    Answer answer;
    if (silent) {
      std::this_thread::sleep_for(milliseconds(10));
      return answer;
    }
    if (lost) {
      lost = false;
      silent = true;
      answer.status = Status::kLost;
      answer.problem = "pulled out";
      return answer;
    }
    if (next_ == fail_at) throw std::runtime_error("broken");
    answer.status = next_ < count_ ? Status::kFrame : Status::kEnded;
    answer.frame.index = next_++;
    return answer;
  }

  std::atomic<bool> silent = false, lost = false, cancelled_ = false;
  std::int64_t fail_at = -1;

 private:
  std::int64_t count_;
  milliseconds pace_;
  std::atomic<std::int64_t> next_ = 0;
};

CaptureQueue::Item NextThatSays(CaptureQueue* queue, CaptureQueue::Event event) {
  const auto start = Clock::now();
  CaptureQueue::Item item;
  do {
    item = queue->Next(milliseconds(20));
  } while (item.event != event && Clock::now() - start < kPatience);
  return item;
}

TEST(CaptureQueue, ARecordingLosesNoFrameHoweverSlowItIsTaken) {
  ScriptedSource source(50, milliseconds(0));
  CaptureQueue queue(&source, {.depth = 3});
  for (int i = 0; i < 50; ++i) {
    if (i % 10 == 0) std::this_thread::sleep_for(milliseconds(20));
    const auto item = queue.Next(kPatience);
    ASSERT_EQ(item.event, CaptureQueue::Event::kFrame);
    EXPECT_EQ(item.frame.index, i);
  }
  EXPECT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kEnded);
  EXPECT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kEnded);
  EXPECT_EQ(queue.dropped(), 0);
}

TEST(CaptureQueue, WhoIsLateGetsTheNewestAndTheOldestAreCounted) {
  ScriptedSource source(20, milliseconds(0));
  CaptureQueue queue(&source, {.depth = 4, .drop_oldest = true});
  std::this_thread::sleep_for(milliseconds(200));  // all have come by now
  for (int i = 16; i < 20; ++i) {
    const auto item = queue.Next(kPatience);
    ASSERT_EQ(item.event, CaptureQueue::Event::kFrame);
    EXPECT_EQ(item.frame.index, i);
  }
  EXPECT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kEnded);
  EXPECT_EQ(queue.dropped(), 16);
}

TEST(CaptureQueue, ASilentCameraIsLostWithinASecondAndFoundAgain) {
  ScriptedSource source(1000, milliseconds(5));
  CaptureQueue queue(&source, {.depth = 4, .drop_oldest = true});
  ASSERT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kFrame);
  source.silent = true;
  const auto start = Clock::now();
  const auto lost = NextThatSays(&queue, CaptureQueue::Event::kLost);
  EXPECT_EQ(lost.event, CaptureQueue::Event::kLost);
  EXPECT_EQ(lost.problem, "no picture comes");
  EXPECT_LT(Clock::now() - start, milliseconds(1000));
  EXPECT_EQ(queue.Next(milliseconds(50)).event, CaptureQueue::Event::kNothing) << "said once";
  EXPECT_GT(queue.seconds_silent(), 0.7);
  source.silent = false;
  EXPECT_EQ(NextThatSays(&queue, CaptureQueue::Event::kFrame).event, CaptureQueue::Event::kFrame);
  EXPECT_LT(queue.seconds_silent(), 0.7);
}

TEST(CaptureQueue, WhatTheSourceSaysOfItsLossIsHandedOnAtOnce) {
  ScriptedSource source(1000, milliseconds(5));
  CaptureQueue queue(&source, {.depth = 4, .drop_oldest = true});
  ASSERT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kFrame);
  source.lost = true;
  const auto start = Clock::now();
  EXPECT_EQ(NextThatSays(&queue, CaptureQueue::Event::kLost).problem, "pulled out");
  EXPECT_LT(Clock::now() - start, milliseconds(400));
}

TEST(CaptureQueue, AFailureComesAfterThePicturesBeforeIt) {
  ScriptedSource source(50, milliseconds(0));
  source.fail_at = 3;
  CaptureQueue queue(&source, {});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kFrame);
  }
  EXPECT_THROW(queue.Next(kPatience), std::runtime_error);
  EXPECT_EQ(queue.Next(kPatience).event, CaptureQueue::Event::kEnded);
}

TEST(CaptureQueue, CanBeLeftAtAnyTime) {
  for (const bool drop : {false, true}) {
    ScriptedSource source(1'000'000, milliseconds(0));
    const auto start = Clock::now();
    {
      CaptureQueue queue(&source, {.depth = 2, .drop_oldest = drop});
      queue.Next(kPatience);
    }
    EXPECT_TRUE(source.cancelled_);
    EXPECT_LT(Clock::now() - start, milliseconds(1000));
  }
}

// A recording of some frames, 25 ms apart.
class Recording final : public FrameSource {
 public:
  explicit Recording(std::int64_t count) : count_(count) {}
  Info info() const override { return {}; }
  Statistics statistics() const override { return {next_, 0}; }
  std::optional<SourceFrame> Next() override {
    if (next_ == count_) return std::nullopt;
    SourceFrame frame;
    frame.index = next_++;
    frame.timestamp = 0.025 * static_cast<double>(frame.index);
    return frame;
  }

 private:
  std::int64_t count_, next_ = 0;
};

TEST(Playback, GoesAtItsOwnPace) {
  const auto source = PlayBack(std::make_unique<Recording>(21), {.realtime = true});
  CaptureQueue queue(source.get(), {.depth = 4, .drop_oldest = true});
  const auto start = Clock::now();
  int frames = 0;
  while (queue.Next(kPatience).event == CaptureQueue::Event::kFrame) ++frames;
  const std::chrono::duration<double> took = Clock::now() - start;
  EXPECT_EQ(frames, 21);
  EXPECT_EQ(queue.dropped(), 0);
  EXPECT_GT(took.count(), 0.49);  // 20 steps of 25 ms; how much longer is the machine's affair
}

TEST(Playback, GivesTheFramesThatWereAskedForAndCanBeCancelled) {
  const auto source =
      PlayBack(std::make_unique<Recording>(100), {.first_frame = 5, .last_frame = 12, .step = 3});
  std::vector<std::int64_t> indices;
  for (auto answer = source->Next(); answer.status != LiveSource::Status::kEnded;
       answer = source->Next()) {
    if (answer.status == LiveSource::Status::kFrame) indices.push_back(answer.frame.index);
  }
  EXPECT_EQ(indices, (std::vector<std::int64_t>{5, 8, 11}));
  source->Cancel();
  EXPECT_EQ(source->Next().status, LiveSource::Status::kNothingYet);
}

}  // namespace
}  // namespace livemvs
