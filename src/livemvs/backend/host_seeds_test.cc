#include "livemvs/backend/cpu/host_seeds.h"

#include <gtest/gtest.h>

#include <array>

namespace livemvs {
namespace {

constexpr std::size_t kCapacity = 20;

// Seeds of which number n carries n in all that it has.
class HostSeedsTest : public ::testing::Test {
 protected:
  void Append(int first, int end) {
    for (int n = first; n < end; ++n) {
      std::array<std::uint8_t, 8 * kPatchSize> image{};
      for (int r = 0; r < kPatchSize; ++r) {
        for (int c = 0; c < kPatchSize; ++c) {
          image[r * 8 + c] = static_cast<std::uint8_t>(n + r * kPatchSize + c);
        }
      }
      const auto f = static_cast<float>(n);
      seeds_.Append({{f + 1, f + 2}, f + 3, f + 4, &image[kPatchRadius * 8 + kPatchRadius], 8},
                    {0.5F, 0.25F, 5, 6});
    }
  }

  void ExpectSeeds(const std::vector<int>& numbers) const {
    const std::vector<SeedState> states = seeds_.Read(0, numbers.size(), 1);
    const std::vector<std::uint8_t> patches = seeds_.ReadPatches(0, numbers.size());
    ASSERT_EQ(states.size(), numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto f = static_cast<float>(numbers[i]);
      EXPECT_EQ(states[i].interval.c0, f + 1);
      EXPECT_EQ(states[i].interval.c1, f + 2);
      EXPECT_EQ(states[i].bearing_x, f + 3);
      EXPECT_EQ(states[i].bearing_y, f + 4);
      EXPECT_EQ(states[i].posterior.mu, 0.5F);
      EXPECT_EQ(states[i].posterior.sigma2, 0.25F);
      EXPECT_EQ(states[i].posterior.a, 5);
      EXPECT_EQ(states[i].posterior.b, 6);
      EXPECT_EQ(states[i].counts.age + states[i].counts.views + states[i].counts.unseen, 0);
      EXPECT_EQ(states[i].fate, Fate::kAlive);
      for (int k = 0; k < kPatchPixels; ++k) {
        EXPECT_EQ(patches[i * kPatchPixels + k], numbers[i] + k);
      }
    }
  }

  void End(const std::vector<std::size_t>& slots) {
    for (const std::size_t i : slots) seeds_.columns().fate[i] = Fate::kConverged;
  }

  HostSeeds seeds_{kCapacity};
};

TEST_F(HostSeedsTest, NewbornsStartWithThePriorAndHaveMetNoFrame) {
  Append(0, 3);
  Append(3, 10);
  ExpectSeeds({0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  const std::vector<SeedState> every_third = seeds_.Read(1, 10, 3);
  ASSERT_EQ(every_third.size(), 3U);
  EXPECT_EQ(every_third[2].bearing_x, 7 + 3);
}

TEST_F(HostSeedsTest, GivesEachEndedSeedOnceInOrder) {
  Append(0, 20);
  End({0, 7, 8, 19});
  std::vector<std::uint32_t> slots;
  for (const EndedSeed& ended : seeds_.TakeEnded()) {
    slots.push_back(ended.slot);
    EXPECT_EQ(ended.seed.fate, Fate::kConverged);
    EXPECT_EQ(ended.seed.bearing_x, static_cast<float>(ended.slot) + 3);
  }
  EXPECT_EQ(slots, (std::vector<std::uint32_t>{0, 7, 8, 19}));
  EXPECT_TRUE(seeds_.TakeEnded().empty());
  End({9});
  ASSERT_EQ(seeds_.TakeEnded().size(), 1U);
}

TEST_F(HostSeedsTest, KeepsTheOrderWhenGapsClose) {
  Append(0, 10);
  End({0, 2, 4, 5, 9});
  seeds_.TakeEnded();
  seeds_.Compact();
  ExpectSeeds({1, 3, 6, 7, 8});
  Append(40, 42);
  ExpectSeeds({1, 3, 6, 7, 8, 40, 41});
  seeds_.Compact();  // without gaps
  ExpectSeeds({1, 3, 6, 7, 8, 40, 41});
}

TEST_F(HostSeedsTest, HasRoomBehindTheLastSeed) {
  EXPECT_EQ(seeds_.room(), kCapacity);
  Append(0, 19);
  EXPECT_EQ(seeds_.room(), 1U);
  Append(19, 20);
  EXPECT_EQ(seeds_.room(), 0U);
  End({3});
  seeds_.TakeEnded();
  EXPECT_EQ(seeds_.room(), 0U) << "the gap is not closed yet";
  seeds_.Compact();
  EXPECT_EQ(seeds_.room(), 1U);
  Append(20, 21);
  EXPECT_EQ(seeds_.room(), 0U);
}

}  // namespace
}  // namespace livemvs
