#include "livemvs/io/prefetcher.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace livemvs {
namespace {

// Frames 0, 1, 2 ...; may fail, or never answer, at one of them.
class CountingDataset final : public Dataset {
 public:
  explicit CountingDataset(std::int64_t count, std::int64_t fail_at = -1)
      : count_(count), fail_at_(fail_at) {}

  std::string description() const override { return "counting"; }
  const std::vector<DatasetView>& views() const override { return views_; }
  const std::vector<Eigen::Vector3d>& sparse_points() const override { return points_; }
  std::optional<Box> box() const override { return std::nullopt; }
  Statistics statistics() const override { return {next_, 0}; }
  std::optional<PosedFrame> Next() override {
    while (stuck) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (next_ == fail_at_) throw std::runtime_error("broken");
    if (next_ == count_) return std::nullopt;
    PosedFrame frame;
    frame.index = next_++;
    return frame;
  }

  std::atomic<bool> stuck = false;

 private:
  std::int64_t count_, fail_at_, next_ = 0;
  std::vector<DatasetView> views_;
  std::vector<Eigen::Vector3d> points_;
};

TEST(PrefetcherTest, HandsOutAllFramesInOrder) {
  CountingDataset dataset(100);
  Prefetcher prefetcher(&dataset, 3);
  for (std::int64_t i = 0; i < 100; ++i) {
    const auto frame = prefetcher.Next();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->index, i);
  }
  EXPECT_FALSE(prefetcher.Next().has_value());
  EXPECT_FALSE(prefetcher.Next().has_value());
  EXPECT_EQ(prefetcher.statistics().decoded, 100);
}

TEST(PrefetcherTest, GivesTheFramesBeforeAFailureFirst) {
  CountingDataset dataset(100, 5);
  Prefetcher prefetcher(&dataset, 2);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(prefetcher.Next().has_value());
  EXPECT_THROW(prefetcher.Next(), std::runtime_error);
}

TEST(PrefetcherTest, EndsWhileFramesWait) {
  CountingDataset dataset(100);
  {
    Prefetcher prefetcher(&dataset, 2);
    EXPECT_TRUE(prefetcher.Next().has_value());
  }
  EXPECT_LE(dataset.statistics().decoded, 5) << "it read far ahead of what was taken";
}

TEST(PrefetcherTest, CanBeCancelledWhileTheDatasetIsSilent) {
  CountingDataset dataset(100);
  dataset.stuck = true;
  Prefetcher prefetcher(&dataset);
  std::atomic<bool> cancelled = false;
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    cancelled = true;
  });
  EXPECT_FALSE(prefetcher.Next([&] { return cancelled.load(); }).has_value());
  canceller.join();
  dataset.stuck = false;
}

}  // namespace
}  // namespace livemvs
