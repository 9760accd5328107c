#include "livemvs/parallel/parallel_for.h"

#include <gtest/gtest.h>

#include <mutex>
#include <set>
#include <utility>
#include <vector>

namespace livemvs {
namespace {

TEST(ParallelForTest, VisitsEveryIndexOnceAndHandsTheResultsBack) {
  std::vector<int> visits(100'000, 0);
  ParallelFor(visits.size(), [&](std::size_t i) { visits[i] += static_cast<int>(i % 7) + 1; });
  for (std::size_t i = 0; i < visits.size(); ++i) {
    ASSERT_EQ(visits[i], static_cast<int>(i % 7) + 1) << i;
  }
}

TEST(ParallelForTest, StretchesFollowOneAnother) {
  std::mutex mutex;
  std::set<std::pair<std::size_t, std::size_t>> stretches;
  ParallelForRange(10, 5000, 64, [&](std::size_t first, std::size_t last) {
    const std::scoped_lock lock(mutex);
    stretches.emplace(first, last);
  });
  std::size_t next = 10;
  for (const auto& [first, last] : stretches) {
    EXPECT_EQ(first, next);
    EXPECT_GT(last, first);
    next = last;
  }
  EXPECT_EQ(next, 5000);
}

TEST(ParallelForTest, NothingToDoCallsNothing) {
  ParallelForRange(7, 7, 1, [](std::size_t, std::size_t) { FAIL(); });
  ParallelForRange(8, 7, 1, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(ParallelForTest, AnExceptionReachesTheCaller) {
  EXPECT_THROW(ParallelFor(1000,
                           [](std::size_t i) {
                             if (i == 500) throw std::runtime_error("500");
                           }),
               std::runtime_error);
}

}  // namespace
}  // namespace livemvs
